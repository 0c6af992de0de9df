/* The rows of a trajectory: records, impacts, changes and contacts, as they come and as they go
 * into the file. */

#include <stdlib.h>

#include "clock.h"
#include "system_impl.h"
#include "trajectory_impl.h"

/* A killed run loses at most what came after the last flush; flushing four times a second keeps
 * that below the second that is promised. */
static const double flush_interval = 0.25;

/* ---- memory */

void nsdae_trajectory_allocate_rows(nsdae_trajectory *t, int forces)
{
  nsdae_h5 *h5 = &t->h5;
  if (h5->status < 0) return;
  if (forces && !nsdae_sim_get_system(t->sim)->maker.sensors.contact_forces)
    h5->status = nsdae_error_set(h5->error, NSDAE_E_ARGUMENT, h5->where, "contact_forces",
                                 "contact_forces = 1, but the system of sim has no solids: "
                                 "nsdae_bodies_system makes such a one");
  t->sizes = nsdae_sizes_of(t->sim, forces);
  for (int i = 0; i < NSDAE_TABLES && h5->status == NSDAE_OK; i++)
    if (nsdae_series_init(&t->rows.series[i],
                          i == NSDAE_RECORDS ? &t->sensors.table : &nsdae_tables[i], &t->sizes,
                          t->compress) < 0)
      nsdae_h5_no_memory(h5);
}

void nsdae_trajectory_release_rows(nsdae_trajectory *t)
{
  for (int i = 0; i < NSDAE_TABLES; i++) nsdae_series_release(&t->rows.series[i]);
  free(t->contacts.point);
}

/* Room for twice the contacts of the record, if there is not enough. */
static int make_room(nsdae_contact_columns *c, int contacts)
{
  if (contacts <= c->room) return NSDAE_OK;
  size_t room = 2 * (size_t)contacts;
  double *point = realloc(c->point, 6 * room * sizeof *point);
  if (!point) return NSDAE_E_MEMORY;
  *c = (nsdae_contact_columns){point, point + 3 * room, (int)room};
  return NSDAE_OK;
}

/* Room for what is held and for what HDF5 keeps of it. */
static void reserve_rows(nsdae_trajectory *t)
{
  long bytes = 0;
  for (int i = 0; i < NSDAE_TABLES; i++) bytes += nsdae_series_held_bytes(&t->rows.series[i]);
  nsdae_h5_prepare(&t->h5, bytes);
}

void nsdae_trajectory_count_rows(nsdae_trajectory *t)
{
  for (int i = 0; i < NSDAE_TABLES; i++) nsdae_series_count(&t->rows.series[i], &t->h5);
  if (nsdae_h5_flush(&t->h5) == NSDAE_OK)
    t->rows.committed = (long)t->rows.series[NSDAE_RECORDS].counted;
}

/* The rows that belong to the state of the simulation: a record that an observer after this one
 * refused was seen here, but the state is the one before it. */
static nsdae_checkpoint_mark mark_of(const nsdae_trajectory *t)
{
  nsdae_record now;
  nsdae_checkpoint_mark mark = {.step = t->rows.step};
  int dropped = nsdae_sim_get_record(t->sim, &now) == NSDAE_OK && now.step < t->rows.step;
  if (dropped) mark.step = now.step;
  for (int i = 0; i < NSDAE_TABLES; i++)
    mark.rows[i] = (int64_t)(dropped ? t->rows.before[i] : nsdae_series_rows(&t->rows.series[i]));
  if (dropped) return mark;
  mark.rows[NSDAE_RECORDS] -= t->rows.extra;
  mark.rows[NSDAE_CONTACTS] -= t->rows.extra_contacts;
  return mark;
}

/* ---- writing */

void nsdae_trajectory_write_state(nsdae_trajectory *t)
{
  nsdae_checkpoint_mark mark = mark_of(t);
  if (t->checkpoint.set >= 0 && t->rows.step >= 0 && t->rows.series[NSDAE_RECORDS].held == 0)
    nsdae_checkpoint_write(&t->checkpoint, &t->h5, t->sim, &mark);
}

void nsdae_trajectory_write_rows(nsdae_trajectory *t, nsdae_series_part part)
{
  reserve_rows(t);
  /* records that are written have their contacts in the file */
  for (int i = 0; i < NSDAE_TABLES; i++)
    nsdae_series_write(&t->rows.series[i], &t->h5, i == NSDAE_CONTACTS ? NSDAE_SERIES_ALL : part);
  nsdae_trajectory_write_state(t);
  nsdae_h5_flush(&t->h5);
  nsdae_trajectory_count_rows(t);
  t->rows.flushed = nsdae_wall_clock();
}

/* ---- appending */

static void append_rows(nsdae_trajectory *t, int table, const nsdae_row *row, int count)
{
  nsdae_series *series = &t->rows.series[table];
  for (int i = 0; i < count && t->h5.status == NSDAE_OK;) {
    i += nsdae_series_append(series, row, i, count - i);
    if (nsdae_series_is_full(series)) { /* rows of one alone */
      nsdae_trajectory_write_rows(t, NSDAE_SERIES_CHUNKS);
    } else if (nsdae_series_ends_chunk(series)) {
      reserve_rows(t);
      nsdae_series_write(series, &t->h5, NSDAE_SERIES_CHUNKS);
    }
  }
}

/* Of the record that the simulation shows. */
static void read_forces(nsdae_trajectory *t, int contacts)
{
  if (!t->sizes.forces || t->h5.status < 0) return;
  if (make_room(&t->contacts, contacts) < 0)
    nsdae_h5_no_memory(&t->h5);
  else
    t->h5.status = nsdae_sim_get_contact_forces(t->sim, t->contacts.point, t->contacts.force);
}

/* The contacts first: a record is never without them. */
static void append_record(nsdae_trajectory *t, const nsdae_record *record)
{
  nsdae_row *row = t->sensors.row;
  if (t->h5.status == NSDAE_OK) t->h5.status = nsdae_sensor_columns_read(&t->sensors, t->sim);
  read_forces(t, record->contacts.count);
  *row = (nsdae_row){.record = *record,
                     .first = (long)nsdae_series_rows(&t->rows.series[NSDAE_CONTACTS]),
                     .point = t->contacts.point,
                     .force = t->contacts.force};
  append_rows(t, NSDAE_CONTACTS, row, nsdae_contact_rows(record));
  append_rows(t, NSDAE_RECORDS, row, 1);
}

/* ---- steps and impacts */

/* A step that comes again takes the place of the one that was dropped. */
static void mark(nsdae_trajectory *t, const nsdae_record *record)
{
  if (record->step == t->rows.step)
    for (int i = 0; i < NSDAE_TABLES; i++)
      nsdae_series_rewind(&t->rows.series[i], t->rows.before[i]);
  for (int i = 0; i < NSDAE_TABLES; i++) t->rows.before[i] = nsdae_series_rows(&t->rows.series[i]);
  t->rows.step = record->step;
}

static int is_due(nsdae_trajectory *t)
{
  double now = nsdae_wall_clock();
  /* a slow run flushes every record: the next may be long in coming */
  int due = now - t->rows.flushed > flush_interval || now - t->rows.appended > flush_interval ||
            now < t->rows.flushed;
  t->rows.appended = now;
  return due && (!t->compress || nsdae_series_ends_chunk(&t->rows.series[NSDAE_RECORDS]));
}

void nsdae_trajectory_take(nsdae_trajectory *t, const nsdae_record *record)
{
  if (!t->begun && t->live) nsdae_h5_start_swmr(&t->h5); /* readers may come */
  t->begun = 1;
  mark(t, record);
  if (record->step % t->rows.every == 0) append_record(t, record);
  for (int i = 0; i < record->impacts; i++) {
    const nsdae_row row = {.impact = record->impact[i]};
    append_rows(t, NSDAE_IMPACTS, &row, 1);
  }
  for (int i = 0; i < record->changes; i++) {
    const nsdae_row row = {.change = record->change[i]};
    append_rows(t, NSDAE_CHANGES, &row, 1);
  }
  if (t->h5.status == NSDAE_OK && is_due(t)) nsdae_trajectory_write_rows(t, NSDAE_SERIES_CHUNKS);
}

void nsdae_trajectory_append_last(nsdae_trajectory *t)
{
  nsdae_record last;
  if (t->rows.step < 0 || t->rows.step % t->rows.every == 0) return;
  if (nsdae_sim_get_record(t->sim, &last) != NSDAE_OK || last.step != t->rows.step) return;
  append_record(t, &last);
  t->rows.extra = 1;
  t->rows.extra_contacts = nsdae_contact_rows(&last);
}
