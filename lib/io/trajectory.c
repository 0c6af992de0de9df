/* A trajectory file as an observer of a simulation. */
#include <nsdae/trajectory.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#include "clock.h"
#include "errors.h"
#include "checkpoint.h"
#include "description.h"
#include "names.h"
#include "series.h"
#include "setting.h"
#include "system_impl.h"

/* A killed run loses at most what came after the last flush; flushing four times a second keeps
 * that below the second that is promised. */
static const double flush_interval = 0.25;

static int no_memory(nsdae_error *error, const char *where)
{
  return nsdae_error_set(error, NSDAE_E_MEMORY, where, "", "out of memory");
}

/* The tables of a file. */
enum { RECORDS, IMPACTS, CHANGES, CONTACTS, TABLES };

static const struct {
  const nsdae_table *table;
  const char *scale; /* name of its first column as a dimension */
} tables[TABLES] = {{&nsdae_record_table, "time"},
                    {&nsdae_impact_table, "impact time"},
                    {&nsdae_change_table, "change time"},
                    {&nsdae_contact_table, "id"}};

struct nsdae_trajectory {
  nsdae_sim *sim;
  nsdae_h5 h5;
  char *path;
  nsdae_params parameters; /* the model's */
  int live;
  int begun;  /* a record came: what is made in a file is made before */
  int bodies; /* were named in place of the system's */
  nsdae_series series[TABLES];
  nsdae_axes axes;
  long every; /* records of such steps are kept */
  int compress;
  long step;              /* of the last record that was seen */
  hsize_t before[TABLES]; /* rows without it */
  nsdae_checkpoint checkpoint;
  int resumed;
  int extra; /* 1: the last row is the end of a run whose step would not have been kept */
  hsize_t extra_contacts;   /* that it has in the list */
  double flushed, appended; /* when */
  long committed;           /* records that the file has whatever happens now */
  int failed;               /* status of a write that failed: nothing is written any more */
};

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

/* Room for what is held and for what HDF5 keeps of it. */
static int prepare(nsdae_trajectory *t)
{
  long bytes = 0;
  for (int i = 0; i < TABLES; i++) bytes += nsdae_series_held_bytes(&t->series[i]);
  return nsdae_h5_prepare(&t->h5, bytes);
}

/* All rows that are written, as rows of the file. */
static int count(nsdae_trajectory *t)
{
  int status = NSDAE_OK;
  for (int i = 0; i < TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_count(&t->series[i], &t->h5);
  if (status == NSDAE_OK) status = nsdae_h5_flush(&t->h5);
  if (status == NSDAE_OK) t->committed = (long)t->series[RECORDS].counted;
  return status;
}

/* The rows that belong to the state of the simulation: a record that an observer after this one
 * refused was seen here, but the state is the one before it. */
static nsdae_checkpoint_mark mark_of(const nsdae_trajectory *t)
{
  nsdae_record now;
  nsdae_checkpoint_mark mark = {.step = t->step};
  int dropped = nsdae_sim_get_record(t->sim, &now) == NSDAE_OK && now.step < t->step;
  if (dropped) mark.step = now.step;
  for (int i = 0; i < TABLES; i++)
    mark.rows[i] = dropped ? t->before[i] : nsdae_series_rows(&t->series[i]);
  if (dropped) return mark;
  mark.rows[RECORDS] -= (hsize_t)t->extra;
  mark.rows[CONTACTS] -= t->extra_contacts;
  return mark;
}

/* Where all records are in the file. */
static int write_state(nsdae_trajectory *t)
{
  nsdae_checkpoint_mark mark = mark_of(t);
  if (t->checkpoint.set < 0 || t->step < 0 || t->series[RECORDS].held > 0) return NSDAE_OK;
  return nsdae_checkpoint_write(&t->checkpoint, &t->h5, t->sim, &mark);
}

/* The rows, and then how many there are: killed in between, a program leaves columns that are
 * longer than the first of their table, never shorter. */
static int flush(nsdae_trajectory *t, nsdae_series_part part)
{
  int status = prepare(t);
  /* records that are written have their contacts in the file */
  for (int i = 0; i < TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_write(&t->series[i], &t->h5, i == CONTACTS ? NSDAE_SERIES_ALL : part);
  if (status == NSDAE_OK) status = write_state(t);
  if (status == NSDAE_OK) status = nsdae_h5_flush(&t->h5);
  if (status == NSDAE_OK) status = count(t);
  t->flushed = nsdae_wall_clock();
  return status;
}

/* Tables that the option compress is for; the others are short. */
static int is_packed(int table)
{
  return table == RECORDS || table == CONTACTS;
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
  if (status < 0) return no_memory(t->h5.error, "nsdae_trajectory_create");
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
    return no_memory(t->h5.error, "nsdae_trajectory_set_bodies");
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

static int make_file(nsdae_trajectory *t, const nsdae_trajectory_info *info)
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
  for (int i = 0; i < TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_create(&t->series[i], h5, &sizes, &t->axes, tables[i].scale,
                                 is_packed(i) ? t->compress : 0);
  return status < 0 ? status : nsdae_h5_flush(h5);
}

/* From the first record on readers may come. */
static int let_readers_in(nsdae_trajectory *t)
{
  t->begun = 1;
  if (!t->live) return NSDAE_OK;
  int status = nsdae_h5_flush(&t->h5);
  return status < 0 ? status : nsdae_h5_start_swmr(&t->h5);
}

static int append_rows(nsdae_trajectory *t, int table, const void *rows, int count)
{
  nsdae_series *series = &t->series[table];
  int status = NSDAE_OK;
  for (int i = 0; i < count && status == NSDAE_OK;) {
    i += nsdae_series_append(series, rows, i, count - i);
    if (nsdae_series_is_full(series)) return flush(t, NSDAE_SERIES_CHUNKS); /* rows of one alone */
    if (!nsdae_series_ends_chunk(series)) continue;
    status = prepare(t);
    if (status == NSDAE_OK) status = nsdae_series_write(series, &t->h5, NSDAE_SERIES_CHUNKS);
  }
  return status;
}

/* The contacts first: a record is never without them. */
static int append_record(nsdae_trajectory *t, const nsdae_record *record)
{
  const nsdae_record_row row = {*record, (long)nsdae_series_rows(&t->series[CONTACTS])};
  int status = append_rows(t, CONTACTS, &record->contacts, record->contacts.count);
  return status < 0 ? status : append_rows(t, RECORDS, &row, 1);
}

static int append_impact(nsdae_trajectory *t, const nsdae_record *record, int i)
{
  const nsdae_contact_set *all = &record->contacts;
  int at = record->impact[i].contact;
  nsdae_impact_row row = {.impact = record->impact[i]};
  if (all->count > 0) {
    row.id = all->id[at];
    memcpy(row.block, all->block + 2 * at, sizeof row.block);
  }
  return append_rows(t, IMPACTS, &row, 1);
}

static int append(nsdae_trajectory *t, const nsdae_record *record)
{
  int status = NSDAE_OK;
  if (record->step % t->every == 0) status = append_record(t, record);
  for (int i = 0; i < record->impacts && status == NSDAE_OK; i++)
    status = append_impact(t, record, i);
  for (int i = 0; i < record->changes && status == NSDAE_OK; i++)
    status = append_rows(t, CHANGES, &record->change[i], 1);
  return status;
}

/* A step that comes again takes the place of the one that was dropped. */
static void mark(nsdae_trajectory *t, const nsdae_record *record)
{
  if (record->step == t->step)
    for (int i = 0; i < TABLES; i++) nsdae_series_rewind(&t->series[i], t->before[i]);
  for (int i = 0; i < TABLES; i++) t->before[i] = nsdae_series_rows(&t->series[i]);
  t->step = record->step;
}

static int is_due(nsdae_trajectory *t)
{
  double now = nsdae_wall_clock();
  /* a slow run flushes every record: the next may be long in coming */
  int due =
      now - t->flushed > flush_interval || now - t->appended > flush_interval || now < t->flushed;
  t->appended = now;
  return due && (!t->compress || nsdae_series_ends_chunk(&t->series[RECORDS]));
}

static int take(nsdae_trajectory *t, const nsdae_record *record)
{
  int status = t->begun ? NSDAE_OK : let_readers_in(t);
  mark(t, record);
  if (status == NSDAE_OK) status = append(t, record);
  return status == NSDAE_OK && is_due(t) ? flush(t, NSDAE_SERIES_CHUNKS) : status;
}

static int observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  nsdae_trajectory *t = user;
  int status;
  if (t->failed) return t->failed;
  t->h5.error = error;
  NSDAE_H5_QUIETLY(status, take(t, record))
  if (status < 0) t->failed = status;
  return status;
}

static void release(nsdae_trajectory *t)
{
  for (int i = 0; i < TABLES; i++) nsdae_series_release(&t->series[i]);
  nsdae_checkpoint_release(&t->checkpoint);
  free(t->path);
  free(t);
}

static int close_file(nsdae_trajectory *t)
{
  for (int i = 0; i < TABLES; i++) nsdae_series_close(&t->series[i]);
  nsdae_axes_close(&t->axes);
  nsdae_checkpoint_close(&t->checkpoint);
  return nsdae_h5_close(&t->h5);
}

static void set_info(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  if (info->parameters) t->parameters = *info->parameters;
  t->live = info->live;
  t->every = info->every > 0 ? info->every : 1;
  t->compress = info->compress;
  t->step = -1;
}

static nsdae_trajectory *allocate(nsdae_sim *sim, const char *path,
                                  const nsdae_trajectory_info *info)
{
  nsdae_sizes sizes;
  nsdae_sizes_of(&sizes, sim);
  nsdae_trajectory *t = calloc(1, sizeof *t);
  if (!t) return NULL;
  t->sim = sim;
  set_info(t, info);
  nsdae_axes_init(&t->axes);
  t->h5.file = -1;
  t->path = malloc(strlen(path) + 1);
  int status = nsdae_checkpoint_init(&t->checkpoint, sim);
  for (int i = 0; i < TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_init(&t->series[i], tables[i].table, &sizes,
                               is_packed(i) && info->compress > 0);
  if (!t->path || status < 0) {
    release(t);
    return NULL;
  }
  t->h5.path = strcpy(t->path, path);
  return t;
}

static int check_info(const nsdae_trajectory_info *info, const char *where, nsdae_error *error)
{
  const char *bad = info->every < 0                            ? "every"
                    : info->compress < 0 || info->compress > 9 ? "compress"
                    : info->compress > 0 && info->live         ? "live"
                                                               : NULL;
  if (!bad) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, bad,
                         "every = %d must be at least 0, compress = %d 0 .. 9, and 0 with live",
                         info->every, info->compress);
}

static int check(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                 nsdae_trajectory **trajectory, const char *where, nsdae_error *error)
{
  const char *missing = !sim          ? "sim"
                        : !path       ? "path"
                        : !info       ? "info"
                        : !trajectory ? "trajectory"
                                      : NULL;
  nsdae_error_clear(error);
  if (!missing) return check_info(info, where, error);
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, missing, "%s is NULL", missing);
}

/* What was made, to the observers and the caller; or away again. */
static int hand_over(nsdae_trajectory *t, int status, nsdae_trajectory **trajectory)
{
  nsdae_error ignored;
  if (status == NSDAE_OK) {
    status = nsdae_sim_observe(t->sim, observe, t);
    if (status < 0) *t->h5.error = *nsdae_sim_error(t->sim);
  }
  if (status == NSDAE_OK) {
    *trajectory = t;
    return NSDAE_OK;
  }
  t->h5.error = &ignored;
  NSDAE_H5_QUIETLY(ignored.status, close_file(t))
  release(t);
  return status;
}

int nsdae_trajectory_create(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                            nsdae_trajectory **trajectory, nsdae_error *error)
{
  nsdae_error own;
  int status = check(sim, path, info, trajectory, "nsdae_trajectory_create", error);
  if (status < 0) return status;
  *trajectory = NULL;
  nsdae_trajectory *t = allocate(sim, path, info);
  if (!t) return no_memory(error, "nsdae_trajectory_create");
  t->h5.error = error ? error : &own;
  NSDAE_H5_QUIETLY(status, make_file(t, info))
  return hand_over(t, status, trajectory);
}

/* ---- going on in a file ---- */

/* How the file keeps its rows is what counts; another wish is refused. */
static int adopt(nsdae_trajectory *t, const nsdae_setting *file, const char *key, int wish,
                 int none, int *value)
{
  char text[NSDAE_SETTING_VALUE];
  *value = nsdae_setting_find(file, "run", key, text) ? atoi(text) : none;
  if (wish == none || wish == *value) return NSDAE_OK;
  return nsdae_error_set(t->h5.error, NSDAE_E_ARGUMENT, "nsdae_trajectory_resume", key,
                         "cannot go on in '%.90s': it has %s %d, this run %d", t->path, key, *value,
                         wish);
}

static int compare(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  nsdae_setting own, file;
  int every = 1, status = nsdae_setting_read(&file, &t->h5);
  if (status < 0) return status;
  status = nsdae_setting_make(&own, t->sim, info);
  if (status < 0) no_memory(t->h5.error, "nsdae_trajectory_resume");
  if (status == NSDAE_OK) status = nsdae_setting_compare(&own, &file, t->path, t->h5.error);
  if (status == NSDAE_OK)
    status = adopt(t, &file, "every", info->every > 1 ? info->every : 1, 1, &every);
  if (status == NSDAE_OK) status = adopt(t, &file, "compress", info->compress, 0, &t->compress);
  t->every = every > 0 ? every : 1;
  for (int i = 0; i < TABLES; i++) t->series[i].packed = is_packed(i) && t->compress > 0;
  nsdae_setting_release(&own);
  nsdae_setting_release(&file);
  return status;
}

static int open_tables(nsdae_trajectory *t, hsize_t rows[TABLES])
{
  nsdae_sizes sizes;
  int status = NSDAE_OK;
  nsdae_sizes_of(&sizes, t->sim);
  for (int i = 0; i < TABLES && status == NSDAE_OK; i++)
    status = nsdae_series_open(&t->series[i], &t->h5, &sizes, &rows[i]);
  return status;
}

/* The simulation stands where the newest whole state is, and the tables behind its rows. What the
 * file has behind them is written again, with the same values, or cut off at the end. */
static int go_on(nsdae_trajectory *t, const hsize_t rows[TABLES])
{
  nsdae_checkpoint_mark mark;
  int status = nsdae_checkpoint_open(&t->checkpoint, &t->h5);
  if (status == NSDAE_OK)
    status = nsdae_checkpoint_take(&t->checkpoint, &t->h5, t->sim, rows, &mark);
  if (status < 0) return status;
  for (int i = 0; i < TABLES; i++) {
    nsdae_series_resume(&t->series[i], mark.rows[i]);
    t->before[i] = mark.rows[i];
  }
  t->step = mark.step;
  t->resumed = t->begun = 1;
  return NSDAE_OK;
}

static int open_again(nsdae_trajectory *t, const nsdae_trajectory_info *info)
{
  hsize_t rows[TABLES];
  int status = nsdae_h5_reopen(&t->h5);
  if (status == NSDAE_OK) status = compare(t, info);
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
  int status = check(sim, path, info, trajectory, where, error);
  if (status < 0) return status;
  *trajectory = NULL;
  if (info->live)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "live",
                           "a run goes on in a file that is not live");
  nsdae_trajectory *t = allocate(sim, path, info);
  if (!t) return no_memory(error, where);
  t->h5.where = where;
  t->h5.error = error ? error : &own;
  NSDAE_H5_QUIETLY(status, open_again(t, info))
  t->h5.where = NULL;
  return hand_over(t, status, trajectory);
}

/* ---- what else ---- */

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
        bad ? "%s is missing or negative" : "nothing can be added to a %s that is live or failed",
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

/* Why no bodies can be named now. */
static int refuse_bodies(const nsdae_trajectory *t, int n, const nsdae_body *body,
                         nsdae_error *error)
{
  const char *bad = !t ? "trajectory" : n < 0 ? "n" : n > 0 && !body ? "body" : NULL;
  static const char where[] = "nsdae_trajectory_set_bodies";
  if (bad)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, bad, "%s is missing or negative", bad);
  if (t->bodies || t->begun || t->failed)
    return nsdae_error_set(error, NSDAE_E_STATE, where, "trajectory", "%s",
                           t->failed   ? "writing the file failed before"
                           : t->bodies ? "the bodies of a file are named once"
                                       : "bodies are named before the first step");
  return NSDAE_OK;
}

int nsdae_trajectory_set_bodies(nsdae_trajectory *trajectory, int n, const nsdae_body *body,
                                nsdae_error *error)
{
  nsdae_error own;
  nsdae_trajectory *t = trajectory;
  nsdae_error_clear(error);
  int status = refuse_bodies(t, n, body, error);
  if (status < 0) return status;
  t->h5.error = error ? error : &own;
  NSDAE_H5_QUIETLY(status, write_bodies(t, n, body))
  t->bodies = status == NSDAE_OK;
  return status;
}

int nsdae_trajectory_flush(nsdae_trajectory *trajectory, nsdae_error *error)
{
  nsdae_error own;
  int status;
  nsdae_trajectory *t = trajectory;
  nsdae_error_clear(error);
  if (!t || t->failed)
    return nsdae_error_set(error, t ? t->failed : NSDAE_E_ARGUMENT, "nsdae_trajectory_flush",
                           "trajectory", t ? "writing '%.90s' failed before" : "%s is NULL",
                           t ? t->path : "trajectory");
  t->h5.error = error ? error : &own;
  NSDAE_H5_QUIETLY(status, flush(t, NSDAE_SERIES_CHUNKS))
  if (status < 0) t->failed = status;
  return status;
}

/* In SWMR mode the attribute can only be changed after the file was closed once. */
static int reopen_live(nsdae_trajectory *t)
{
  if (!t->live) return NSDAE_OK;
  int status = close_file(t);
  return status < 0 ? status : nsdae_h5_reopen(&t->h5);
}

static int end_file(nsdae_trajectory *t, int run_status)
{
  int status = count(t);
  if (status == NSDAE_OK) status = reopen_live(t);
  if (status == NSDAE_OK) status = nsdae_description_set_ended(&t->h5, run_status);
  int closed = close_file(t);
  return status < 0 ? status : closed;
}

/* A write failed: the file is as the last flush left it, and is to say how it ended, which needs no
 * more space on a full disk. A file that is not ours any more is left alone. */
static void mark_failed(nsdae_trajectory *t)
{
  nsdae_h5 *h5 = &t->h5;
  const nsdae_ordered before = h5->disk;
  if (before.failure == NSDAE_ORDERED_REPLACED || before.committed == 0) return;
  if (nsdae_h5_reopen(h5) < 0) return;
  if (h5->disk.inode == before.inode && h5->disk.device == before.device)
    nsdae_description_set_ended(h5, NSDAE_E_IO);
  nsdae_h5_close(h5);
}

/* The last state is kept in any case; a run that goes on from it has its row where it belongs. */
static int append_last(nsdae_trajectory *t)
{
  nsdae_record last;
  if (t->step < 0 || t->step % t->every == 0) return NSDAE_OK;
  if (nsdae_sim_get_record(t->sim, &last) != NSDAE_OK || last.step != t->step) return NSDAE_OK;
  int status = append_record(t, &last);
  t->extra = 1;
  t->extra_contacts = (hsize_t)last.contacts.count;
  return status;
}

/* What an earlier run left behind the rows of this one goes. */
static int flush_last(nsdae_trajectory *t)
{
  int status = append_last(t);
  if (status == NSDAE_OK) status = flush(t, NSDAE_SERIES_ALL);
  if (status == NSDAE_OK)
    status = write_state(t); /* both places: the same bytes whenever the flushes were */
  if (status == NSDAE_OK) status = nsdae_checkpoint_trim(&t->checkpoint, &t->h5);
  for (int i = 0; i < TABLES && status == NSDAE_OK && t->resumed; i++)
    if (nsdae_series_exists(&t->series[i])) status = nsdae_series_cut(&t->series[i], &t->h5);
  return status;
}

/* Of several failures the first is told. */
static int finish(nsdae_trajectory *t, int run_status)
{
  nsdae_error ignored, *first = t->h5.error;
  int status = t->failed ? t->failed : flush_last(t);
  if (status < 0) t->h5.error = &ignored;
  int ended = end_file(t, status < 0 ? status : run_status);
  t->h5.error = &ignored;
  if (ended < 0) mark_failed(t);
  t->h5.error = first;
  return status < 0 ? status : ended;
}

int nsdae_trajectory_close(nsdae_trajectory **trajectory, int run_status, nsdae_error *error)
{
  nsdae_error own;
  int status;
  nsdae_error_clear(error);
  if (!trajectory || !*trajectory) return NSDAE_OK;
  nsdae_trajectory *t = *trajectory;
  t->h5.error = error ? error : &own;
  nsdae_sim_unobserve(t->sim, observe, t);
  if (t->failed)
    nsdae_error_set(error, t->failed, "nsdae_trajectory_close", "path",
                    "'%.90s' holds %ld records only: writing it failed before", t->path,
                    t->committed);
  NSDAE_H5_QUIETLY(status, finish(t, run_status))
  release(t);
  *trajectory = NULL;
  return status;
}
