#include "published.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void published_follow(last_record *last, int coordinates, const nsdae_record *record)
{
  last->time = record->time;
  memcpy(last->q, record->q, (size_t)coordinates * sizeof *last->q);
  memcpy(last->v, record->v, (size_t)coordinates * sizeof *last->v);
}

/* A double has at most 16. */
static double digits(double x, double expected)
{
  return -log10(fmax(fabs(x / expected - 1), 1e-16));
}

double published_digits(const published *p, const char *quantity, const double *x)
{
  double least = 16;
  for (int i = 0; i < p->n; i++)
    if (strcmp(p->value[i].quantity, quantity) == 0)
      least = fmin(least, digits(x[p->value[i].index], p->value[i].value));
  return least;
}

int published_state(const published *p, int number, driver_state *state)
{
  if (number >= p->n || strcmp(p->value[number].quantity, "q") != 0) return 0;
  *state = (driver_state){
      .time = p->time, .value = p->value[number].value, .coordinate = p->value[number].index};
  return 1;
}

void published_print(const published *p, const last_record *last)
{
  if (fabs(last->time - p->time) > 1e-9 * p->time) return;
  printf("published values at %g s\n", p->time);
  for (int i = 0; i < p->n; i++) {
    const published_value *value = &p->value[i];
    if (strcmp(value->quantity, "lambda") == 0) continue;
    double x = (value->quantity[0] == 'q' ? last->q : last->v)[value->index];
    printf("  %s[%d] %23.16e  published %23.16e  digits %4.1f\n", value->quantity, value->index, x,
           value->value, digits(x, value->value));
  }
}
