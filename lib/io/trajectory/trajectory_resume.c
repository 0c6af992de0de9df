/* Going on in the file of an earlier run. */
#include <stdlib.h>

#include "description.h"
#include "errors.h"
#include "run_settings.h"
#include "trajectory_impl.h"

/* How the file keeps its rows is what counts; another wish is refused. */
static int adopt(nsdae_trajectory *t, const nsdae_setting *file, const char *key, int wish,
                 int none, int *value)
{
  char text[NSDAE_SETTING_VALUE];
  *value = nsdae_setting_find(file, "run", key, text) ? atoi(text) : none;
  if (wish == none || wish == *value) return NSDAE_OK;
  return nsdae_error_set(t->h5.error, NSDAE_E_ARGUMENT, "nsdae_trajectory_resume", key,
                         "cannot resume '%.90s': it has %s %d, this run %d", t->path, key, *value,
                         wish);
}

static int compare_run(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_setting own, file;
  int every = 1, status = nsdae_setting_read(&file, &t->h5);
  if (status < 0) return status;
  status = nsdae_setting_make(&own, t->sim, info);
  if (status < 0) nsdae_error_memory(t->h5.error, "nsdae_trajectory_resume");
  if (status == NSDAE_OK) status = nsdae_setting_compare(&own, &file, t->path, t->h5.error);
  if (status == NSDAE_OK)
    status = adopt(t, &file, "every", info->every > 1 ? info->every : 1, 1, &every);
  if (status == NSDAE_OK) status = adopt(t, &file, "compress", info->compress, 0, &t->compress);
  t->rows.every = every > 0 ? every : 1;
  for (int i = 0; i < NSDAE_TABLES; i++)
    t->rows.series[i].packed = nsdae_trajectory_is_packed(i) && t->compress > 0;
  nsdae_setting_release(&own);
  nsdae_setting_release(&file);
  return status;
}

static int open_tables(nsdae_trajectory *t, hsize_t rows[NSDAE_TABLES])
{
  nsdae_sizes sizes;
  int status = NSDAE_OK;
  nsdae_sizes_of(&sizes, t->sim);
  for (int i = 0; i < NSDAE_TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_open(&t->rows.series[i], &t->h5, &sizes, &rows[i]);
  return status;
}

/* The simulation stands where the newest whole state is, and the tables behind its rows. What the
 * file has behind them is written again, with the same values, or cut off at the end. */
static int go_on(nsdae_trajectory *t, const hsize_t rows[NSDAE_TABLES])
{
  nsdae_checkpoint_mark mark;
  int status = nsdae_checkpoint_open(&t->checkpoint, &t->h5);
  if (status == NSDAE_OK)
    status = nsdae_checkpoint_take(&t->checkpoint, &t->h5, t->sim, rows, &mark);
  if (status < 0) return status;
  for (int i = 0; i < NSDAE_TABLES; i++) {
    nsdae_series_resume(&t->rows.series[i], mark.rows[i]);
    t->rows.before[i] = mark.rows[i];
  }
  t->rows.step = mark.step;
  t->resumed = t->begun = 1;
  return NSDAE_OK;
}

static int open_again(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  hsize_t rows[NSDAE_TABLES];
  int status = nsdae_h5_reopen(&t->h5);
  if (status == NSDAE_OK) status = compare_run(t, info);
  if (status == NSDAE_OK) status = open_tables(t, rows);
  if (status == NSDAE_OK) status = go_on(t, rows);
  if (status == NSDAE_OK) status = nsdae_description_set_running(&t->h5);
  return status < 0 ? status : nsdae_h5_flush(&t->h5);
}

int nsdae_trajectory_resume(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                            nsdae_trajectory **trajectory, nsdae_error *error)
{
  static const char where[] = "nsdae_trajectory_resume";
  nsdae_error own;
  int status = nsdae_trajectory_check(sim, path, info, trajectory, where, error);
  if (status < 0) return status;
  *trajectory = NULL;
  if (info->live)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "live", "a live file cannot be resumed");
  nsdae_trajectory *t = nsdae_trajectory_allocate(sim, path, info);
  if (!t) return nsdae_error_memory(error, where);
  t->h5.where = where;
  t->h5.error = error ? error : &own;
  NSDAE_H5_QUIETLY(status, open_again(t, info))
  t->h5.where = NULL;
  return nsdae_trajectory_hand_over(t, status, trajectory);
}
