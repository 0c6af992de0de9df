/* What a run prints: parameters, the table of impacts as they come, the summary. */
#ifndef NSDAE_DRIVER_REPORT_H
#define NSDAE_DRIVER_REPORT_H

#include <stdio.h>

#include "brief.h"
#include "progress.h"
#include "settings.h"

typedef struct report {
  const settings *settings;
  int contacts, tangents; /* k, nt */
  int rows;               /* of the impact table so far */
  int exact;              /* something is known of the impacts */
  double fastest;         /* closing velocity of them [m/s] */
  brief brief;
  bar bar;
} report;

void report_begin(report *r, const settings *s, const nsdae_sim *sim);

/* Observer: adds impacts to the table and moves the progress bar. user is the report. */
int report_observe(const nsdae_record *record, nsdae_error *error, void *user);

void report_end(report *r, const nsdae_sim *sim, const nsdae_system *system);

#endif
