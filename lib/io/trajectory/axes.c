#include "axes.h"

#include <stdio.h>
#include <stdlib.h>

#include "errors.h"

enum { COORDINATE, VELOCITY, CONSTRAINT, CONTACT, TANGENT, SLIDE, SIDE };

static const struct axis {
  const char *path, *name; /* the dimension has the dataset's name */
  const char *letter;      /* name of number i where it has none: q0, v0, ... */
  const char *what;
  int kind;              /* enum nsdae_name_kind, or -1 */
  const char *unit_path; /* NULL: of the file's own */
} axis[NSDAE_AXES] = {
    [COORDINATE] = {"/coordinate", "coordinate", "q", "names of the coordinates",
                    NSDAE_NAME_COORDINATE, "/coordinate_unit"},
    [VELOCITY] = {"/velocity", "velocity", "v", "names of the velocities", NSDAE_NAME_VELOCITY,
                  "/velocity_unit"},
    [CONSTRAINT] = {"/constraint", "constraint", "constraint", "names of the constraints",
                    NSDAE_NAME_CONSTRAINT, "/constraint_unit"},
    [CONTACT] = {"/contact/contact", "contact", "contact", "names of the contacts",
                 NSDAE_NAME_CONTACT, NULL},
    [TANGENT] = {"/tangent", "tangent", "tangent", "tangential directions of a contact", -1, NULL},
    [SLIDE] = {"/slide/slide", "slide", "frictional_joint",
               "names of the bilateral constraints with friction", NSDAE_NAME_FRICTIONAL_JOINT,
               NULL},
    [SIDE] = {"/side", "side", "side", "sides of a contact", -1, NULL},
};

/* Past this number, one that has no name is its number: a text each costs more than the data. */
enum { NAMED_MOST = 4096, NAME_SIZE = 64 };

static int length_of(int i, const nsdae_sizes *sizes)
{
  const nsdae_dims *dims = &sizes->dims;
  int contacts = dims->k > 0 || sizes->listed;
  const int length[NSDAE_AXES] = {
      dims->nq, dims->nv, dims->m, dims->k, contacts ? dims->nt : 0, dims->f, 2 * sizes->listed};
  return length[i];
}

static void write_name(const nsdae_system *system, int i, int number, char text[NAME_SIZE])
{
  const char *given = axis[i].kind < 0 ? "" : nsdae_system_get_name(system, axis[i].kind, number);
  if (*given)
    snprintf(text, NAME_SIZE, "%s", given);
  else
    snprintf(text, NAME_SIZE, "%s%d", axis[i].letter, number);
}

static void write_unit(const nsdae_system *system, int i, int number, char text[NAME_SIZE])
{
  snprintf(text, NAME_SIZE, "%s", nsdae_system_get_unit(system, axis[i].kind, number));
}

/* A dataset of n texts, each filled by `fill`. */
static int write_texts(nsdae_h5 *h5, const char *path, const char *what,
                       void (*fill)(const nsdae_system *, int, int, char *),
                       const nsdae_system *system, int i, int n)
{
  char **text = malloc((size_t)n * (sizeof *text + NAME_SIZE));
  if (!text) return nsdae_error_memory(h5->error, "nsdae_trajectory");
  for (int j = 0; j < n; j++) {
    text[j] = (char *)(text + n) + (size_t)j * NAME_SIZE;
    fill(system, i, j, text[j]);
  }
  int status = nsdae_h5_vector(h5, path, H5T_C_S1, (hsize_t)n, text, "", what);
  free(text);
  return status;
}

static int write_numbers(nsdae_h5 *h5, int i, int n)
{
  int *number = malloc((size_t)n * sizeof *number);
  if (!number) return nsdae_error_memory(h5->error, "nsdae_trajectory");
  for (int j = 0; j < n; j++) number[j] = j;
  int status =
      nsdae_h5_vector(h5, axis[i].path, H5T_NATIVE_INT, (hsize_t)n, number, "1", axis[i].what);
  free(number);
  return status;
}

static int create_scale(nsdae_axes *axes, nsdae_h5 *h5, const nsdae_system *system, int i, int n)
{
  int status = n > NAMED_MOST
                   ? write_numbers(h5, i, n)
                   : write_texts(h5, axis[i].path, axis[i].what, write_name, system, i, n);
  if (status == NSDAE_OK) status = nsdae_h5_open_dataset(h5, axis[i].path, &axes->scale[i]);
  return status < 0 ? status : nsdae_h5_make_scale(h5, axes->scale[i], axis[i].name);
}

/* The units beside the names, with the names as their dimension. */
static int create_units(nsdae_axes *axes, nsdae_h5 *h5, const nsdae_system *system, int i, int n)
{
  hid_t set;
  const char *path = axis[i].unit_path;
  if (!path || n > NAMED_MOST) return NSDAE_OK;
  int status = write_texts(h5, path, "units of these", write_unit, system, i, n);
  if (status == NSDAE_OK) status = nsdae_h5_open_dataset(h5, path, &set);
  if (status < 0) return status;
  status = nsdae_h5_attach_scale(h5, set, axes->scale[i], 0);
  H5Dclose(set);
  return status;
}

void nsdae_axes_init(nsdae_axes *axes)
{
  for (int i = 0; i < NSDAE_AXES; i++) axes->scale[i] = -1;
}

int nsdae_axes_create(nsdae_axes *axes, nsdae_h5 *h5, const nsdae_sim *sim)
{
  nsdae_sizes sizes;
  int status = NSDAE_OK;
  const nsdae_system *system = nsdae_sim_get_system(sim);
  nsdae_sizes_of(&sizes, sim);
  for (int i = 0; i < NSDAE_AXES && status == NSDAE_OK; i++) {
    int n = length_of(i, &sizes);
    if (n == 0) continue;
    status = create_scale(axes, h5, system, i, n);
    if (status == NSDAE_OK) status = create_units(axes, h5, system, i, n);
  }
  return status;
}

hid_t nsdae_axes_of(const nsdae_axes *axes, nsdae_width width, int i)
{
  static const int first[] = {
      [NSDAE_WIDTH_PAIR] = SIDE,  [NSDAE_WIDTH_LISTED_T] = TANGENT, [NSDAE_WIDTH_Q] = COORDINATE,
      [NSDAE_WIDTH_V] = VELOCITY, [NSDAE_WIDTH_M] = CONSTRAINT,     [NSDAE_WIDTH_K] = CONTACT,
      [NSDAE_WIDTH_KT] = CONTACT, [NSDAE_WIDTH_T] = TANGENT,        [NSDAE_WIDTH_F] = SLIDE};
  return axes->scale[i == 1 ? TANGENT : first[width]];
}

void nsdae_axes_close(nsdae_axes *axes)
{
  for (int i = 0; i < NSDAE_AXES; i++) {
    if (axes->scale[i] >= 0) H5Dclose(axes->scale[i]);
    axes->scale[i] = -1;
  }
}
