#include "series.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct axis {
  const char *path;   /* the dimension has the dataset's name */
  const char *letter; /* name of number i where it has none: q0, v0, ... */
  const char *what;
  int kind;              /* enum nsdae_name_kind, or -1 */
  const char *unit_path; /* NULL: of the file's own */
} axis[NSDAE_AXES] = {
    [NSDAE_WIDTH_Q] = {"/coordinate", "q", "names of the coordinates", NSDAE_NAME_COORDINATE,
                       "/coordinate_unit"},
    [NSDAE_WIDTH_V] = {"/velocity", "v", "names of the velocities", NSDAE_NAME_VELOCITY,
                       "/velocity_unit"},
    [NSDAE_WIDTH_M] = {"/constraint", "constraint", "names of the constraints",
                       NSDAE_NAME_CONSTRAINT, "/constraint_unit"},
    [NSDAE_WIDTH_K] = {"/contacts/contact", "contact", "names of the contacts", NSDAE_NAME_CONTACT,
                       "/contacts/contact_unit"},
    [NSDAE_WIDTH_T] = {"/tangent", "tangent", "tangential directions of a contact", -1, NULL},
    [NSDAE_WIDTH_F] = {"/frictional_joint/frictional_joint", "frictional_joint",
                       "names of the frictional joints", NSDAE_NAME_FRICTIONAL_JOINT,
                       "/frictional_joint/frictional_joint_unit"},
    [NSDAE_WIDTH_PAIR] = {"/side", "side", "sides of a contact", -1, NULL},
    [NSDAE_WIDTH_TWO] = {"/component2", "component", "x, y of a sensor in the plane", -1, NULL},
    [NSDAE_WIDTH_THREE] = {"/component3", "component", "x, y, z of a sensor in space", -1, NULL},
    [NSDAE_WIDTH_FOUR] = {"/component4", "component", "w, x, y, z of a quaternion", -1, NULL},
};

/* Past this number, one that has no name is its number: a text each costs more than the data. */
enum { NAMED_MOST = 4096, NAME_SIZE = 64 };

/* The names of axis i, or their units, as a dataset of n texts. */
static void write_texts(nsdae_h5 *h5, const nsdae_system *system, int i, int n, int units)
{
  const struct axis *a = &axis[i];
  char **text = nsdae_h5_allocate(h5, (size_t)n, sizeof *text + NAME_SIZE);
  for (int j = 0; text && j < n; j++) {
    const char *given = units         ? nsdae_system_get_unit(system, a->kind, j)
                        : a->kind < 0 ? ""
                                      : nsdae_system_get_name(system, a->kind, j);
    text[j] = (char *)(text + n) + (size_t)j * NAME_SIZE;
    if (units || *given)
      snprintf(text[j], NAME_SIZE, "%s", given);
    else
      snprintf(text[j], NAME_SIZE, "%s%d", a->letter, j);
  }
  nsdae_h5_vector(h5, units ? a->unit_path : a->path, H5T_C_S1, (hsize_t)n, text, "",
                  units ? "units of these" : a->what);
  free(text);
}

static void write_numbers(nsdae_h5 *h5, int i, int n)
{
  int *number = nsdae_h5_allocate(h5, (size_t)n, sizeof *number);
  for (int j = 0; number && j < n; j++) number[j] = j;
  nsdae_h5_vector(h5, axis[i].path, H5T_NATIVE_INT, (hsize_t)n, number, "1", axis[i].what);
  free(number);
}

void nsdae_axes_create(hid_t scale[NSDAE_AXES], nsdae_h5 *h5, const nsdae_sim *sim)
{
  const nsdae_system *system = nsdae_sim_get_system(sim);
  nsdae_sizes sizes = nsdae_sizes_of(sim);
  for (int i = 0; i < NSDAE_AXES; i++) {
    int n = sizes.axis[i];
    scale[i] = -1;
    if (n == 0) continue;
    if (n > NAMED_MOST)
      write_numbers(h5, i, n);
    else
      write_texts(h5, system, i, n, 0);
    scale[i] = nsdae_h5_open_dataset(h5, axis[i].path);
    nsdae_h5_make_scale(h5, scale[i], strrchr(axis[i].path, '/') + 1);
    if (!axis[i].unit_path || n > NAMED_MOST) continue;
    /* the units beside the names, with the names as their dimension */
    write_texts(h5, system, i, n, 1);
    hid_t set = nsdae_h5_open_dataset(h5, axis[i].unit_path);
    nsdae_h5_attach_scale(h5, set, scale[i], 0);
    if (set >= 0) H5Dclose(set);
  }
}
