/* A trajectory file as an observer of a simulation. */
#include <stdlib.h>
#include <string.h>

#include "description.h"
#include "trajectory_impl.h"

static int observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  nsdae_trajectory *t = user;
  if (t->failed) return t->failed;
  nsdae_h5_start(&t->h5, error);
  H5E_BEGIN_TRY
    nsdae_trajectory_take(t, record);
  H5E_END_TRY
  t->failed = t->h5.status;
  return t->failed;
}

/* ---- memory and file */

static void release(nsdae_trajectory *t)
{
  nsdae_trajectory_release_rows(t);
  nsdae_checkpoint_release(&t->checkpoint);
  nsdae_sensor_columns_release(&t->sensors);
  free(t->path);
  free(t);
}

/* What failed to be made, with its file. */
static void abandon(nsdae_trajectory *t)
{
  nsdae_h5_start(&t->h5, NULL);
  nsdae_h5_close(&t->h5);
  release(t);
}

/* NULL: out of memory. */
static nsdae_trajectory *allocate(nsdae_sim *sim, const char *path,
                                  const nsdae_trajectory_info *info)
{
  nsdae_trajectory *t = calloc(1, sizeof *t);
  if (!t) return NULL;
  t->sim = sim;
  if (info->parameters) t->parameters = *info->parameters;
  t->live = info->live;
  t->compress = info->compress;
  t->rows.every = info->every > 0 ? info->every : 1;
  t->rows.step = -1;
  t->path = malloc(strlen(path) + 1);
  int status = nsdae_checkpoint_init(&t->checkpoint, sim);
  if (status == NSDAE_OK) status = nsdae_sensor_columns_init(&t->sensors, sim);
  if (!t->path || status < 0) {
    release(t);
    return NULL;
  }
  t->h5 = (nsdae_h5){.file = -1, .path = strcpy(t->path, path), .where = "nsdae_trajectory"};
  return t;
}

/* ---- creating */

static int check_info(const nsdae_trajectory_info *info, const char *where, nsdae_error *error)
{
  int forces = info->contact_forces;
  const char *bad = info->every < 0                            ? "every"
                    : info->compress < 0 || info->compress > 9 ? "compress"
                    : info->compress > 0 && info->live         ? "live"
                    : forces < 0 || forces > 1                 ? "contact_forces"
                                                               : NULL;
  if (!bad) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, bad,
                         "every = %d must be at least 0, compress = %d 0 .. 9, and 0 with live, "
                         "contact_forces = %d 0 or 1",
                         info->every, info->compress, forces);
}

/* The error of the simulation as that of the call; returns status. */
static int fail_with_sim(const nsdae_sim *sim, int status, nsdae_error *error)
{
  if (status < 0 && error) *error = *nsdae_sim_error(sim);
  return status;
}

/* A callback, or a thread beside the one that steps, cannot read the simulation. */
static int readable(const nsdae_sim *sim, nsdae_error *error)
{
  nsdae_sim_options ignored;
  return fail_with_sim(sim, nsdae_sim_get_options(sim, &ignored), error);
}

int nsdae_trajectory_start(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                           nsdae_trajectory **trajectory, nsdae_error *error, const char *where,
                           void (*open)(nsdae_trajectory *, const nsdae_trajectory_info *))
{
  const char *missing = !sim          ? "sim"
                        : !path       ? "path"
                        : !info       ? "info"
                        : !trajectory ? "trajectory"
                                      : NULL;
  nsdae_error_clear(error);
  if (missing)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, missing, "%s is NULL", missing);
  int status = readable(sim, error);
  if (status == NSDAE_OK) status = check_info(info, where, error);
  if (status < 0) return status;
  *trajectory = NULL;
  nsdae_trajectory *t = allocate(sim, path, info);
  if (!t) return nsdae_error_memory(error, where);
  nsdae_h5_start(&t->h5, error);
  H5E_BEGIN_TRY
    open(t, info);
    status = t->h5.status;
    if (status == NSDAE_OK) status = fail_with_sim(sim, nsdae_sim_observe(sim, observe, t), error);
    if (status == NSDAE_OK)
      *trajectory = t;
    else
      abandon(t);
  H5E_END_TRY
  return status;
}

/* ---- flushing */

int nsdae_trajectory_flush(nsdae_trajectory *trajectory, nsdae_error *error)
{
  nsdae_trajectory *t = trajectory;
  nsdae_error_clear(error);
  if (!t || t->failed)
    return nsdae_error_set(error, t ? t->failed : NSDAE_E_ARGUMENT, "nsdae_trajectory_flush",
                           "trajectory", t ? "writing '%.90s' failed before" : "%s is NULL",
                           t ? t->path : "trajectory");
  int status = readable(t->sim, error);
  if (status < 0) return status;
  nsdae_h5_start(&t->h5, error);
  H5E_BEGIN_TRY
    nsdae_trajectory_write_rows(t, NSDAE_SERIES_CHUNKS);
  H5E_END_TRY
  t->failed = t->h5.status;
  return t->failed;
}

/* ---- closing */

/* In SWMR mode the attribute can only be changed after the file was closed once. */
static int end_file(nsdae_trajectory *t, int run_status)
{
  nsdae_trajectory_count_rows(t);
  if (t->live && t->h5.status == NSDAE_OK) {
    nsdae_h5_close(&t->h5);
    nsdae_h5_reopen(&t->h5, 0);
  }
  nsdae_description_set_ended(&t->h5, run_status);
  return nsdae_h5_close(&t->h5);
}

/* A write failed: the file is as the last flush left it, and is to say how it ended, which needs no
 * more space on a full disk. A file that is not ours any more is left alone. */
static void mark_failed(nsdae_h5 *h5)
{
  const nsdae_vfd before = h5->disk;
  if (before.failure == NSDAE_VFD_REPLACED || before.committed == 0) return;
  if (nsdae_h5_reopen(h5, 0) < 0) return;
  if (h5->disk.number == before.number && h5->disk.device == before.device)
    nsdae_description_set_ended(h5, NSDAE_E_IO);
  nsdae_h5_close(h5);
}

/* What an earlier run left behind the rows of this one goes. */
static void flush_last(nsdae_trajectory *t)
{
  nsdae_trajectory_append_last(t);
  nsdae_trajectory_write_rows(t, NSDAE_SERIES_ALL);
  nsdae_trajectory_write_state(t); /* both places: the same bytes whenever the flushes were */
  nsdae_checkpoint_trim(&t->checkpoint, &t->h5);
  for (int i = 0; i < NSDAE_TABLES && t->resumed; i++) nsdae_series_cut(&t->rows.series[i], &t->h5);
}

/* Of several failures the first is reported. */
static int finish_file(nsdae_trajectory *t, int run_status, nsdae_error *error)
{
  nsdae_h5 *h5 = &t->h5;
  nsdae_h5_start(h5, error);
  if (!t->failed) flush_last(t);
  int status = t->failed ? t->failed : h5->status;
  nsdae_h5_start(h5, status < 0 ? NULL : error);
  int ended = end_file(t, status < 0 ? status : run_status);
  nsdae_h5_start(h5, NULL);
  if (ended < 0) mark_failed(h5);
  return status < 0 ? status : ended;
}

int nsdae_trajectory_close(nsdae_trajectory **trajectory, int run_status, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!trajectory || !*trajectory) return NSDAE_OK;
  nsdae_trajectory *t = *trajectory;
  int status = readable(t->sim, error);
  if (status < 0) return status;
  nsdae_sim_unobserve(t->sim, observe, t);
  if (t->failed)
    nsdae_error_set(error, t->failed, "nsdae_trajectory_close", "path",
                    "'%.90s' holds %ld records only: writing it failed before", t->path,
                    t->rows.committed);
  H5E_BEGIN_TRY
    status = finish_file(t, run_status, error);
  H5E_END_TRY
  release(t);
  *trajectory = NULL;
  return status;
}
