/* Names of a model's coordinates, constraints and contacts, as a table. */
#ifndef NSDAE_MODEL_NAMES_H
#define NSDAE_MODEL_NAMES_H

#include <nsdae/system.h>

typedef struct model_name {
  int kind; /* enum nsdae_name_kind */
  const char *name, *unit;
} model_name;

/* The first of a kind is number 0, the next number 1. What is refused the system remembers. */
void model_names(nsdae_system *system, int count, const model_name *names);

#define MODEL_NAMES(system, names) \
  model_names((system), (int)(sizeof(names) / sizeof *(names)), (names))

#endif
