/* Going on in the file of an earlier run. */
#include <stdlib.h>

#include "description.h"
#include "run_settings.h"
#include "trajectory_impl.h"

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
  for (int i = 0; i < NSDAE_TABLES; i++)
    t->rows.series[i].deflate = nsdae_tables[i].packed ? t->compress : 0;
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
  nsdae_h5_reopen(h5);
  compare_run(t, info);
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
