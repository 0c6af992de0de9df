/* What a trajectory file has beside its rows. */
#include <stdio.h>

#include "shapes_data.h"
#include "description.h"
#include "errors.h"
#include "formula_names.h"
#include "run_settings.h"
#include "system_impl.h"
#include "trajectory_impl.h"

/* ---- contents */

static int make_groups(nsdae_h5 *h5, const nsdae_sizes *sizes)
{
  const struct {
    const char *path;
    int wanted;
  } group[] = {{"/energy", 1},
               {"/certificate", 1},
               {"/impact", 1},
               {"/change", 1},
               {"/contact", sizes->dims.k > 0},
               {"/slide", sizes->dims.f > 0},
               {"/contacts", sizes->listed}};
  int status = NSDAE_OK;
  for (size_t i = 0; i < sizeof group / sizeof *group && status == NSDAE_OK; i++)
    if (group[i].wanted) status = nsdae_h5_group(h5, group[i].path);
  return status;
}

static nsdae_h5_kind kind_of(const nsdae_trajectory *t)
{
  return t->live ? NSDAE_H5_LIVE : t->compress ? NSDAE_H5_PACKED : NSDAE_H5_PLAIN;
}

/* What a later program needs to go on in this file. */
static int make_restart(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_setting setting;
  int status = nsdae_setting_make(&setting, t->sim, info);
  if (status < 0) return nsdae_error_memory(t->h5.error, "nsdae_trajectory_create");
  status = nsdae_checkpoint_create(&t->checkpoint, &t->h5);
  if (status == NSDAE_OK) status = nsdae_setting_write(&setting, &t->h5);
  nsdae_setting_release(&setting);
  return status;
}

/* Checks the bodies against the names that their formulas may use, then writes them. */
static int write_bodies(nsdae_trajectory *t, int n, const nsdae_body *body)
{
  nsdae_sizes sizes;
  nsdae_formula_names names;
  nsdae_sizes_of(&sizes, t->sim);
  if (nsdae_names_make(&names, t->sim, &t->parameters) < 0)
    return nsdae_error_memory(t->h5.error, "nsdae_trajectory_set_bodies");
  int status = nsdae_bodies_check(n, body, &names, t->h5.error);
  if (status == NSDAE_OK) status = nsdae_h5_remove(&t->h5, "/bodies");
  if (status == NSDAE_OK) status = nsdae_h5_remove(&t->h5, "/shapes");
  if (status == NSDAE_OK) status = nsdae_bodies_write(&t->h5, n, body, &names, sizes.listed);
  nsdae_names_release(&names);
  return status;
}

/* What the system itself has to show. */
static int write_own_bodies(nsdae_trajectory *t)
{
  int n;
  nsdae_error *error = t->h5.error;
  const nsdae_body *body = nsdae_system_get_bodies(nsdae_sim_get_system(t->sim), &n);
  int status = n > 0 ? write_bodies(t, n, body) : NSDAE_OK;
  if (status < 0) snprintf(error->where, sizeof error->where, "nsdae_trajectory_create");
  return status;
}

/* Where the blocks of a large system begin, for whoever reads whose contacts they are. */
static int write_blocks(nsdae_trajectory *t)
{
  const nsdae_system *system = nsdae_sim_get_system(t->sim);
  if (!system->by_list) return NSDAE_OK;
  hsize_t n = (hsize_t)system->blocks.count;
  int status = nsdae_h5_vector(&t->h5, "/blocks/q", H5T_NATIVE_INT, n, system->coordinates.first,
                               "1", "first coordinate of each block");
  if (status < 0) return status;
  return nsdae_h5_vector(&t->h5, "/blocks/v", H5T_NATIVE_INT, n, system->blocks.first, "1",
                         "first velocity of each block");
}

/* ---- file */

int nsdae_trajectory_make_file(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_h5 *h5 = &t->h5;
  nsdae_sizes sizes;
  nsdae_sizes_of(&sizes, t->sim);
  int status = nsdae_h5_create(h5, kind_of(t));
  if (status == NSDAE_OK) status = nsdae_description_write(h5, t->sim, info);
  if (status == NSDAE_OK) status = make_groups(h5, &sizes);
  if (status == NSDAE_OK) status = nsdae_axes_create(&t->axes, h5, t->sim);
  if (status == NSDAE_OK && !t->live) status = make_restart(t, info);
  if (status == NSDAE_OK) status = write_own_bodies(t);
  if (status == NSDAE_OK) status = write_blocks(t);
  for (int i = 0; i < NSDAE_TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_create(&t->rows.series[i], h5, &sizes, &t->axes,
                                 nsdae_trajectory_tables[i].scale,
                                 nsdae_trajectory_is_packed(i) ? t->compress : 0);
  return status < 0 ? status : nsdae_h5_flush(h5);
}

/* ---- interface */

static int put(nsdae_trajectory *t, const char *path, hid_t type, int n, const void *values,
               const char *units, const char *description, nsdae_error *error)
{
  nsdae_error own;
  int status;
  nsdae_error_clear(error);
  const char *bad = !t ? "trajectory" : !path ? "path" : n < 0 ? "n" : !values ? "values" : NULL;
  if (bad || t->live || t->failed)
    return nsdae_error_set(
        error, NSDAE_E_ARGUMENT, "nsdae_trajectory_put", bad ? bad : "trajectory",
        bad ? "%s is missing or negative" : "data cannot be added to a %s that is live or failed",
        bad ? bad : "trajectory");
  t->h5.error = error ? error : &own;
  if (t->resumed) NSDAE_H5_QUIETLY(status, nsdae_h5_remove(&t->h5, path))
  NSDAE_H5_QUIETLY(status, nsdae_h5_vector(&t->h5, path, type, (hsize_t)n, values,
                                           units ? units : "", description ? description : ""))
  return status;
}

int nsdae_trajectory_put(nsdae_trajectory *trajectory, const char *path, int n,
                         const double *values, const char *units, const char *description,
                         nsdae_error *error)
{
  return put(trajectory, path, H5T_NATIVE_DOUBLE, n, values, units, description, error);
}

int nsdae_trajectory_put_texts(nsdae_trajectory *trajectory, const char *path, int n,
                               const char *const *texts, const char *description,
                               nsdae_error *error)
{
  return put(trajectory, path, H5T_C_S1, n, texts, "", description, error);
}

int nsdae_trajectory_set_bodies(nsdae_trajectory *trajectory, int n, const nsdae_body *body,
                                nsdae_error *error)
{
  nsdae_error own;
  nsdae_trajectory *t = trajectory;
  nsdae_error_clear(error);
  const char *bad = !t ? "trajectory" : n < 0 ? "n" : n > 0 && !body ? "body" : NULL;
  static const char where[] = "nsdae_trajectory_set_bodies";
  if (bad)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, bad, "%s is missing or negative", bad);
  if (t->bodies || t->begun || t->failed)
    return nsdae_error_set(error, NSDAE_E_STATE, where, "trajectory", "%s",
                           t->failed   ? "writing the file failed before"
                           : t->bodies ? "the bodies of a file are named once"
                                       : "bodies are named before the first step");
  int status = NSDAE_OK;
  t->h5.error = error ? error : &own;
  NSDAE_H5_QUIETLY(status, write_bodies(t, n, body))
  t->bodies = status == NSDAE_OK;
  return status;
}
