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

static int sort(int n, const char *const *name, int *order)
{
  entry *all = malloc((size_t)n * sizeof *all);
  if (!all) return NSDAE_E_MEMORY;
  for (int i = 0; i < n; i++) all[i] = (entry){name[i], i};
  qsort(all, (size_t)n, sizeof *all, compare_names);
  for (int i = 0; i < n; i++) order[i] = all[i].number;
  free(all);
  return NSDAE_OK;
}

int nsdae_names_make(nsdae_formula_names *names, const nsdae_sim *sim,
                     const nsdae_params *parameters)
{
  nsdae_dims dims;
  const nsdae_system *system = nsdae_sim_get_system(sim);
  nsdae_sim_get_dims(sim, &dims);
  const char **name = malloc((size_t)dims.nq * sizeof *name);
  int *order = malloc((size_t)dims.nq * sizeof *order);
  *names = (nsdae_formula_names){dims.nq, name, order, parameters};
  int status = name && order ? NSDAE_OK : NSDAE_E_MEMORY;
  for (int i = 0; i < dims.nq && status == NSDAE_OK; i++)
    name[i] = nsdae_system_get_name(system, NSDAE_NAME_COORDINATE, i);
  if (status == NSDAE_OK) status = sort(dims.nq, name, order);
  if (status < 0) nsdae_names_release(names);
  return status;
}

void nsdae_names_release(nsdae_formula_names *names)
{
  free((void *)(uintptr_t)names->coordinate);
  free((void *)(uintptr_t)names->order);
  *names = (nsdae_formula_names){0};
}
