/* What was read from files is released, in a library with HDF5 or without. */
#include <nsdae/friction_file.h>
#include <nsdae/lcp_file.h>
#include <stdlib.h>

void nsdae_lcp_file_release(nsdae_lcp_file *file)
{
  if (!file) return;
  free(file->A);
  free(file->b);
  *file = (nsdae_lcp_file){0};
}

void nsdae_friction_file_release(nsdae_friction_file *file)
{
  if (!file) return;
  const nsdae_friction_problem *p = &file->problem;
  const void *const held[] = {p->rows, p->mu,     p->w,        p->size,       p->M,
                              p->f,    p->first,  p->block,    p->value,      p->compliance,
                              file->r, file->low, file->guess, file->velocity};
  for (size_t i = 0; i < sizeof held / sizeof *held; i++) free((void *)held[i]);
  *file = (nsdae_friction_file){0};
}
