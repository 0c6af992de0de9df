#include "friction_sequence.h"

#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int read_key(hid_t file, const char *name, int contacts, int **key)
{
  hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = set < 0 ? set : H5Dget_space(set);
  int good = space >= 0 && H5Sget_simple_extent_npoints(space) == contacts;
  *key = calloc((size_t)contacts + 1, sizeof **key);
  good = good && *key && H5Dread(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, *key) >= 0;
  if (space >= 0) H5Sclose(space);
  if (set >= 0) H5Dclose(set);
  return good;
}

static int read_keys(const char *path, friction_instant *s)
{
  static const char *const names[] = {"/contacts/geom1", "/contacts/geom2", "/contacts/index"};
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  int good = file >= 0;
  for (int k = 0; k < 3 && good; k++)
    good = read_key(file, names[k], s->file.problem.contacts, &s->key[k]);
  if (file >= 0) H5Fclose(file);
  return good;
}

int friction_instant_read(const char *folder, int number, friction_instant *s)
{
  char path[1024];
  *s = (friction_instant){.r = NULL};
  snprintf(path, sizeof path, "%s/step%02d.hdf5", folder, number);
  FILE *stream = fopen(path, "rb");
  if (!stream) return 0;
  fclose(stream);
  if (nsdae_friction_read(path, &s->file, NULL) != NSDAE_OK) return -1;
  s->r = calloc(3 * (size_t)s->file.problem.contacts + 1, sizeof *s->r);
  return s->r && read_keys(path, s) ? 1 : -1;
}

static int same(const friction_instant *a, int i, const friction_instant *b, int j)
{
  for (int k = 0; k < 3; k++)
    if (a->key[k][i] != b->key[k][j]) return 0;
  return 1;
}

void friction_instant_hand_on(const friction_instant *before, friction_instant *s)
{
  memset(s->r, 0, 3 * (size_t)s->file.problem.contacts * sizeof *s->r);
  for (int i = 0; i < s->file.problem.contacts; i++)
    for (int j = 0; j < before->file.problem.contacts; j++)
      if (same(s, i, before, j)) memcpy(s->r + 3 * i, before->r + 3 * j, 3 * sizeof *s->r);
}

void friction_instant_release(friction_instant *s)
{
  nsdae_friction_file_release(&s->file);
  for (int k = 0; k < 3; k++) free(s->key[k]);
  free(s->r);
  *s = (friction_instant){.r = NULL};
}
