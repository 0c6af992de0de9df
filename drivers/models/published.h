/* Published values of a mechanism at the end of its run. */
#ifndef NSDAE_MODEL_PUBLISHED_H
#define NSDAE_MODEL_PUBLISHED_H

#include "driver.h"

enum { PUBLISHED_MAX = 8 }; /* coordinates */

/* One value: "q", "v" or "lambda". */
typedef struct published_value {
  const char *quantity;
  int index;
  double value;
} published_value;

typedef struct published {
  double time; /* [s] */
  int n;       /* values */
  const published_value *value;
} published;

/* The last record of a run. */
typedef struct last_record {
  double time;
  double q[PUBLISHED_MAX], v[PUBLISHED_MAX];
} last_record;

void published_follow(last_record *last, int coordinates, const nsdae_record *record);

/* Least number of correct digits, -log10 |x / published - 1|, of one quantity. */
double published_digits(const published *p, const char *quantity, const double *x);

/* driver_model.state. */
int published_state(const published *p, int number, driver_state *state);

/* Prints each coordinate and velocity beside its published value, if the run ended at its time. */
void published_print(const published *p, const last_record *last);

#endif
