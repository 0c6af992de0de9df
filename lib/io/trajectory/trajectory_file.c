/* What a trajectory file has beside its rows: a new one, or that of an earlier run. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "description.h"
#include "system_impl.h"
#include "trajectory_impl.h"

/* ---- contents */

static nsdae_h5_kind kind_of(const nsdae_trajectory *t)
{
  return t->live ? NSDAE_H5_LIVE : t->compress ? NSDAE_H5_PACKED : NSDAE_H5_PLAIN;
}

/* What a later program needs to go on in this file. */
static void make_restart(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_setting setting;
  nsdae_setting_make(&setting, &t->h5, t->sim, info);
  nsdae_checkpoint_create(&t->checkpoint, &t->h5);
  nsdae_setting_write(&setting, &t->h5);
  nsdae_setting_release(&setting);
}

/* The coordinates that have names, in the order of these, each name once. */
static nsdae_named *sort_coordinates(nsdae_h5 *h5, const nsdae_system *system, int nq, int *named)
{
  nsdae_named *c = nsdae_h5_allocate(h5, (size_t)nq, sizeof *c);
  *named = 0;
  for (int i = 0; c && i < nq; i++)
    c[i] = (nsdae_named){nsdae_system_get_name(system, NSDAE_NAME_COORDINATE, i), i};
  if (c) qsort(c, (size_t)nq, sizeof *c, nsdae_named_order);
  for (int i = 0; c && i < nq; i++)
    if (*c[i].name && (*named == 0 || strcmp(c[*named - 1].name, c[i].name) != 0))
      c[(*named)++] = c[i];
  return c;
}

/* Checks the bodies against the names that their formulas may use, then writes them. */
static void write_bodies(nsdae_trajectory *t, int n, const nsdae_body *body)
{
  nsdae_h5 *h5 = &t->h5;
  nsdae_formula_names names = {.parameters = &t->parameters};
  names.nq = t->sizes.axis[NSDAE_WIDTH_Q];
  nsdae_named *coordinate =
      sort_coordinates(h5, nsdae_sim_get_system(t->sim), names.nq, &names.named);
  names.coordinate = coordinate;
  nsdae_bodies_check(h5, n, body, &names);
  if (h5->status == NSDAE_OK) {
    H5Ldelete(h5->file, "/bodies", H5P_DEFAULT); /* fails if there is none */
    H5Ldelete(h5->file, "/shapes", H5P_DEFAULT);
    nsdae_bodies_write(h5, n, body, &names, t->sizes.varies);
  }
  free(coordinate);
}

/* What the system itself has to show. */
static void write_own_bodies(nsdae_trajectory *t)
{
  int n;
  const nsdae_body *body = nsdae_system_get_bodies(nsdae_sim_get_system(t->sim), &n);
  if (t->h5.status < 0 || n == 0) return;
  write_bodies(t, n, body);
}

/* The ids of fixed contacts, beside their names; which of the two kinds the group has. */
static void write_contacts(nsdae_h5 *h5, int k, int varies, hid_t names)
{
  static const char id_path[] = "/contacts/id";
  if (k == 0 && !varies) return;
  if (k > 0) {
    long *id = nsdae_h5_allocate(h5, (size_t)k, sizeof *id);
    for (int i = 0; id && i < k; i++) id[i] = i;
    nsdae_h5_vector(h5, id_path, H5T_NATIVE_LONG, (hsize_t)k, id, "1", "number of the contact");
    free(id);
    hid_t set = nsdae_h5_open_dataset(h5, id_path);
    nsdae_h5_attach_scale(h5, set, names, 0);
    if (set >= 0) H5Dclose(set);
  }
  hid_t group = h5->status < 0 ? -1 : H5Gopen2(h5->file, "/contacts", H5P_DEFAULT);
  if (h5->status == NSDAE_OK) nsdae_h5_result(h5, group, "write to");
  nsdae_h5_set_int(h5, group, "fixed", k);
  if (group >= 0) H5Gclose(group);
}

/* Where the blocks of a large system begin, for whoever reads whose contacts they are. */
static void write_blocks(nsdae_h5 *h5, const nsdae_system *system)
{
  hsize_t n = (hsize_t)system->blocks.count;
  if (!system->call.contacts) return;
  nsdae_h5_vector(h5, "/blocks/q", H5T_NATIVE_INT, n, system->coordinates.first, "1",
                  "first coordinate of each block");
  nsdae_h5_vector(h5, "/blocks/v", H5T_NATIVE_INT, n, system->blocks.first, "1",
                  "first velocity of each block");
}

/* ---- file */

static void make_file(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_h5 *h5 = &t->h5;
  const nsdae_system *system = nsdae_sim_get_system(t->sim);
  hid_t axes[NSDAE_AXES];
  h5->where = "nsdae_trajectory_create";
  nsdae_trajectory_allocate_rows(t, info->contact_forces);
  if (h5->status < 0 || nsdae_h5_create(h5, kind_of(t)) < 0) return;
  nsdae_description_write(h5, t->sim, info);
  nsdae_axes_create(axes, h5, system, &t->sizes);
  if (!t->live) make_restart(t, info);
  write_own_bodies(t);
  write_blocks(h5, system);
  nsdae_series *series = t->rows.series;
  for (int i = 0; i < NSDAE_TABLES; i++) {
    int of_records = nsdae_tables[i].by_contact && !t->sizes.varies;
    nsdae_series_create(&series[i], h5, system, axes,
                        of_records ? series[NSDAE_RECORDS].column[0].set : -1);
  }
  write_contacts(h5, t->sizes.axis[NSDAE_WIDTH_K], t->sizes.varies, axes[NSDAE_WIDTH_K]);
  nsdae_h5_flush(h5);
  h5->where = "nsdae_trajectory";
}

int nsdae_trajectory_create(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                            nsdae_trajectory **trajectory, nsdae_error *error)
{
  return nsdae_trajectory_start(sim, path, info, trajectory, error, "nsdae_trajectory_create",
                                make_file);
}

/* ---- the file of an earlier run */

/* How the file keeps its rows is what counts; another wish is refused. */
static int adopt(nsdae_h5 *h5, const nsdae_setting *file, const char *key, int wish, int none)
{
  char name[NSDAE_H5_PATH], text[NSDAE_SETTING_VALUE];
  int value = nsdae_setting_find(file, nsdae_h5_join(name, "run", key), text) ? atoi(text) : none;
  if (wish != none && wish != value && h5->status == NSDAE_OK)
    h5->status = nsdae_error_set(h5->error, NSDAE_E_ARGUMENT, h5->where, key,
                                 "cannot resume '%.90s': it has %s %d, this run %d", h5->path, key,
                                 value, wish);
  return value;
}

static void compare_run(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_h5 *h5 = &t->h5;
  nsdae_setting own, file;
  nsdae_setting_read(&file, h5);
  nsdae_setting_make(&own, h5, t->sim, info);
  nsdae_setting_compare(&own, &file, h5);
  int every = adopt(h5, &file, "every", info->every > 1 ? info->every : 1, 1);
  t->compress = adopt(h5, &file, "compress", info->compress, 0);
  t->rows.every = every > 0 ? every : 1;
  nsdae_trajectory_allocate_rows(t,
                                 adopt(h5, &file, "contact_forces", info->contact_forces, 0) != 0);
  nsdae_setting_release(&own);
  nsdae_setting_release(&file);
}

/* The simulation stands where the newest whole state is, and the tables behind its rows. What the
 * file has behind them is written again, with the same values, or cut off at the end. */
static void open_again(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  hsize_t rows[NSDAE_TABLES];
  nsdae_checkpoint_mark mark = {0};
  nsdae_h5 *h5 = &t->h5;
  h5->where = "nsdae_trajectory_resume";
  if (info->live)
    h5->status = nsdae_error_set(h5->error, NSDAE_E_ARGUMENT, h5->where, "live",
                                 "a live file cannot be resumed");
  nsdae_h5_reopen(h5, 1);
  nsdae_description_check(h5);
  compare_run(t, info);
  if (h5->status < 0) return;
  for (int i = 0; i < NSDAE_TABLES; i++) rows[i] = nsdae_series_open(&t->rows.series[i], h5);
  nsdae_checkpoint_take(&t->checkpoint, h5, t->sim, rows, &mark);
  for (int i = 0; i < NSDAE_TABLES; i++) {
    t->rows.before[i] = (hsize_t)mark.rows[i];
    nsdae_series_resume(&t->rows.series[i], t->rows.before[i]);
  }
  t->rows.step = (long)mark.step;
  t->resumed = t->begun = 1;
  nsdae_h5_set_text(h5, h5->file, "status", "running");
  nsdae_h5_flush(h5);
  h5->where = "nsdae_trajectory";
}

int nsdae_trajectory_resume(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                            nsdae_trajectory **trajectory, nsdae_error *error)
{
  return nsdae_trajectory_start(sim, path, info, trajectory, error, "nsdae_trajectory_resume",
                                open_again);
}

/* ---- interface */

static int put(nsdae_trajectory *t, const char *path, hid_t type, int n, const void *values,
               const char *units, const char *description, nsdae_error *error)
{
  nsdae_error_clear(error);
  const char *bad = !t ? "trajectory" : !path ? "path" : n < 0 ? "n" : !values ? "values" : NULL;
  if (bad || t->live || t->failed)
    return nsdae_error_set(
        error, NSDAE_E_ARGUMENT, "nsdae_trajectory_put", bad ? bad : "trajectory",
        bad ? "%s is missing or negative" : "data cannot be added to a %s that is live or failed",
        bad ? bad : "trajectory");
  nsdae_h5_start(&t->h5, error);
  H5E_BEGIN_TRY
    if (t->resumed) H5Ldelete(t->h5.file, path, H5P_DEFAULT); /* fails if there is none */
    nsdae_h5_vector(&t->h5, path, type, (hsize_t)n, values, units ? units : "",
                    description ? description : "");
  H5E_END_TRY
  return t->h5.status;
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
  nsdae_h5_start(&t->h5, error);
  t->h5.where = where;
  H5E_BEGIN_TRY
    write_bodies(t, n, body);
  H5E_END_TRY
  t->h5.where = "nsdae_trajectory";
  t->bodies = t->h5.status == NSDAE_OK;
  return t->h5.status;
}
