/* Which runs a sweep has: a grid of parameters, and draws at random. */
#ifndef NSDAE_SWEEP_PLAN_H
#define NSDAE_SWEEP_PLAN_H

#include <nsdae/nsdae.h>

enum { PLAN_PARAMETERS_MAX = 16, PLAN_NAME_SIZE = 64 };

/* A parameter and the values that it takes along its dimension. */
typedef struct plan_parameter {
  char name[PLAN_NAME_SIZE];
  int dimension;
  double *value; /* [length of its dimension] */
  double low, high;
  int drawn;
} plan_parameter;

typedef struct plan {
  plan_parameter parameter[PLAN_PARAMETERS_MAX];
  int parameters;
  long length[PLAN_PARAMETERS_MAX + 1]; /* of each dimension; the last one is that of the draws */
  int dimensions;
  long draws;    /* 0: none */
  unsigned seed; /* of the draws */
  long runs;     /* in all; the last dimension runs fastest */
} sweep_plan;

/* Adds "NAME=LOW:HIGH:COUNT", "NAME=V,V,..." or, for draws, "NAME=LOW:HIGH". */
int plan_add(sweep_plan *p, const char *text, nsdae_error *error);

/* When everything is added: dimensions, draws, how many runs there are. */
int plan_complete(sweep_plan *p, nsdae_error *error);

/* Value of a parameter in a run. */
double plan_value(const sweep_plan *p, int parameter, long run);

/* "r=0.015, mu=0.1" */
void plan_describe(const sweep_plan *p, long run, char *text, size_t size);

void plan_release(sweep_plan *p);

#endif
