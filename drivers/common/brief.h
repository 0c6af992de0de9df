/* A run in one line: steps, impacts, one result beside its exact value, time. */
#ifndef NSDAE_DRIVER_BRIEF_H
#define NSDAE_DRIVER_BRIEF_H

#include "settings.h"

/* What the line needs of the records. */
typedef struct brief {
  const settings *settings;
  long impacts;
  double first_impulse; /* of the first impact [N s] */
  int states;           /* reference states passed so far */
  driver_state state;   /* the last of them */
  double at_state;      /* the coordinate at its time */
} brief;

void brief_begin(brief *b, const settings *s);
void brief_observe(brief *b, const nsdae_record *record);
/* Prints the line, and below it the warnings of the run. */
void brief_end(const brief *b, const nsdae_sim *sim, const nsdae_system *system);

#endif
