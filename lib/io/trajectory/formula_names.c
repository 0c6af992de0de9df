#include "formula_names.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct entry {
  const char *name;
  int number;
} entry;

static int compare_names(const void *a, const void *b)
{
  const entry *x = a, *y = b;
  int order = strcmp(x->name, y->name);
  return order ? order : (x->number > y->number) - (x->number < y->number);
}

void nsdae_names_make(nsdae_formula_names *names, nsdae_h5 *h5, const nsdae_sim *sim,
                      const nsdae_params *parameters)
{
  nsdae_dims dims;
  nsdae_sim_get_dims(sim, &dims);
  size_t n = (size_t)dims.nq;
  const char **name = nsdae_h5_allocate(h5, n, sizeof *name);
  int *order = nsdae_h5_allocate(h5, n, sizeof *order);
  entry *all = nsdae_h5_allocate(h5, n, sizeof *all);
  *names = (nsdae_formula_names){dims.nq, name, order, parameters};
  for (int i = 0; all && i < dims.nq; i++) {
    name[i] = nsdae_system_get_name(nsdae_sim_get_system(sim), NSDAE_NAME_COORDINATE, i);
    all[i] = (entry){name[i], i};
  }
  if (all) qsort(all, n, sizeof *all, compare_names);
  for (int i = 0; all && i < dims.nq; i++) order[i] = all[i].number;
  free(all);
}

void nsdae_names_release(nsdae_formula_names *names)
{
  free((void *)(uintptr_t)names->coordinate);
  free((void *)(uintptr_t)names->order);
  *names = (nsdae_formula_names){0};
}
