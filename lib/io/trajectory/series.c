#include "series.h"

#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "hdf5_read.h"

/* A chunk of a column is at most so long, unless a row is longer: what is kept of a large system's
 * records is bounded by it, and 1024 rows of most systems are less. */
static const size_t chunk_bytes = (size_t)4 << 20;

/* ---- rows and chunks */

static hid_t value_type(const nsdae_column *column)
{
  return column->value == NSDAE_VALUE_INT    ? H5T_NATIVE_INT
         : column->value == NSDAE_VALUE_LONG ? H5T_NATIVE_LONG
                                             : H5T_NATIVE_DOUBLE;
}

static size_t row_bytes(const nsdae_column *column, const nsdae_sizes *sizes)
{
  static const size_t size[] = {[NSDAE_VALUE_REAL] = sizeof(double),
                                [NSDAE_VALUE_INT] = sizeof(int),
                                [NSDAE_VALUE_LONG] = sizeof(long)};
  int shape[2];
  nsdae_width_shape(column->width, sizes, shape);
  return size[column->value] * (size_t)shape[0] * (size_t)shape[1];
}

/* The table's, halved until the widest column's is short enough. */
static hsize_t chunk_rows(const nsdae_table *table, const nsdae_sizes *sizes)
{
  size_t widest = 1, rows = (size_t)table->chunk;
  for (int i = 0; i < table->columns; i++) {
    size_t bytes = row_bytes(&table->column[i], sizes);
    if (bytes > widest) widest = bytes;
  }
  while (rows > 1 && widest > chunk_bytes / rows) rows /= 2;
  return rows;
}

/* Columns before it count rows and are written at flushes. */
static int first_written(const nsdae_series *series)
{
  return series->table->counts ? 1 : 0;
}

static size_t rows_kept(const nsdae_series *series, size_t column)
{
  return (int)column < first_written(series) ? NSDAE_SERIES_ROWS_MAX : series->chunk;
}

int nsdae_series_init(nsdae_series *series, const nsdae_table *table, const nsdae_sizes *sizes,
                      int packed)
{
  size_t columns = (size_t)table->columns;
  *series = (nsdae_series){.table = table, .packed = packed, .chunk = chunk_rows(table, sizes)};
  series->set = malloc(columns * sizeof *series->set);
  series->bytes = calloc(columns, sizeof *series->bytes);
  series->buffer = calloc(columns, sizeof *series->buffer);
  if (!series->set || !series->bytes || !series->buffer) return NSDAE_E_MEMORY;
  for (size_t i = 0; i < columns; i++) {
    series->set[i] = -1;
    series->bytes[i] = row_bytes(&table->column[i], sizes);
    if (series->bytes[i] == 0) continue;
    series->buffer[i] = malloc(series->bytes[i] * rows_kept(series, i));
    if (!series->buffer[i]) return NSDAE_E_MEMORY;
  }
  return NSDAE_OK;
}

void nsdae_series_release(nsdae_series *series)
{
  if (series->buffer)
    for (int i = 0; i < series->table->columns; i++) free(series->buffer[i]);
  free(series->buffer);
  free(series->bytes);
  free(series->set);
  *series = (nsdae_series){0};
}

/* ---- creating and opening */

static int create_column(nsdae_series *series, nsdae_h5 *h5, const nsdae_sizes *sizes, int i,
                         int deflate)
{
  const nsdae_column *column = &series->table->column[i];
  int shape[2], rank = nsdae_width_shape(column->width, sizes, shape);
  const hsize_t width[2] = {(hsize_t)shape[0], (hsize_t)shape[1]};
  int status = nsdae_h5_series(h5, column->path, value_type(column), width, rank + 1, series->chunk,
                               deflate, &series->set[i]);
  if (status == NSDAE_OK)
    status = nsdae_h5_describe(h5, series->set[i], column->units, column->description);
  return status;
}

/* The first column's rows and the axes, as dimensions of column i. */
static int attach(nsdae_series *series, nsdae_h5 *h5, const nsdae_axes *axes, int i)
{
  nsdae_width width = series->table->column[i].width;
  int status = nsdae_h5_attach_scale(h5, series->set[i], series->set[0], 0);
  int more = width < NSDAE_WIDTH_PAIR ? 0 : width == NSDAE_WIDTH_KT ? 2 : 1;
  for (int d = 0; d < more && status == NSDAE_OK; d++)
    status = nsdae_h5_attach_scale(h5, series->set[i], nsdae_axes_of(axes, width, d), d + 1);
  return status;
}

int nsdae_series_create(nsdae_series *series, nsdae_h5 *h5, const nsdae_sizes *sizes,
                        const nsdae_axes *axes, const char *scale, int deflate)
{
  int status = NSDAE_OK;
  for (int i = 0; i < series->table->columns && status == NSDAE_OK; i++) {
    if (series->bytes[i] == 0) continue;
    status = create_column(series, h5, sizes, i, deflate);
    if (status < 0) break;
    status = i == 0 ? nsdae_h5_make_scale(h5, series->set[0], scale) : attach(series, h5, axes, i);
  }
  return status;
}

/* Whether the file's dataset of column i has its shape; rows becomes its length if that is less. */
static int look_at_column(const nsdae_series *series, nsdae_h5 *h5, const nsdae_sizes *sizes, int i,
                          hsize_t *rows)
{
  const nsdae_column *column = &series->table->column[i];
  int shape[2], rank = nsdae_width_shape(column->width, sizes, shape);
  hsize_t length[NSDAE_H5_RANK_MAX] = {0, 1, 1};
  int status = nsdae_h5_shape(h5, column->path, rank + 1, length);
  if (status < 0) return status;
  if (length[0] < *rows) *rows = length[0];
  if (length[1] == (hsize_t)shape[0] && length[2] == (hsize_t)shape[1]) return NSDAE_OK;
  return nsdae_error_set(h5->error, NSDAE_E_IO, "nsdae_trajectory_resume", "path",
                         "cannot resume '%.90s': %s has rows of another length", h5->path,
                         column->path);
}

int nsdae_series_open(nsdae_series *series, nsdae_h5 *h5, const nsdae_sizes *sizes, hsize_t *rows)
{
  int status = NSDAE_OK;
  *rows = (hsize_t)-1;
  for (int i = 0; i < series->table->columns && status == NSDAE_OK; i++) {
    if (series->bytes[i] == 0) continue;
    status = look_at_column(series, h5, sizes, i, rows);
    if (status == NSDAE_OK)
      status = nsdae_h5_open_series(h5, series->table->column[i].path, &series->set[i]);
  }
  return status;
}

void nsdae_series_resume(nsdae_series *series, hsize_t rows)
{
  series->written = rows;
  series->counted = series->table->counts ? rows : 0;
  series->held = 0;
}

int nsdae_series_cut(nsdae_series *series, nsdae_h5 *h5)
{
  int status = NSDAE_OK, first = first_written(series);
  if (first == 1) {
    status = nsdae_h5_cut(h5, series->set[0], series->counted);
    if (status == NSDAE_OK) status = nsdae_h5_flush(h5);
  }
  for (int i = first; i < series->table->columns && status == NSDAE_OK; i++)
    if (series->set[i] >= 0) status = nsdae_h5_cut(h5, series->set[i], series->written);
  return status;
}

/* ---- writing */

static int write_column(nsdae_series *series, nsdae_h5 *h5, int i, hsize_t from, hsize_t rows)
{
  return nsdae_h5_append(h5, series->set[i], value_type(&series->table->column[i]), from, rows,
                         series->buffer[i]);
}

hsize_t nsdae_series_rows(const nsdae_series *series)
{
  return series->written + series->held;
}

int nsdae_series_ends_chunk(const nsdae_series *series)
{
  return nsdae_series_rows(series) % series->chunk == 0;
}

int nsdae_series_exists(const nsdae_series *series)
{
  return series->bytes[0] > 0;
}

void nsdae_series_rewind(nsdae_series *series, hsize_t rows)
{
  if (rows < series->written) series->written = rows;
  if (rows < series->counted) series->counted = rows;
  series->held = rows - series->written;
}

int nsdae_series_write(nsdae_series *series, nsdae_h5 *h5, nsdae_series_part part)
{
  int status = NSDAE_OK;
  if (series->packed && part == NSDAE_SERIES_CHUNKS && !nsdae_series_ends_chunk(series))
    return NSDAE_OK;
  for (int i = first_written(series);
       i < series->table->columns && series->held > 0 && status == NSDAE_OK; i++)
    if (series->set[i] >= 0) status = write_column(series, h5, i, series->written, series->held);
  if (status < 0) return status;
  series->written += series->held;
  series->held = 0;
  return NSDAE_OK;
}

int nsdae_series_count(nsdae_series *series, nsdae_h5 *h5)
{
  if (!series->table->counts) return NSDAE_OK;
  hsize_t rows = series->written - series->counted;
  int status = rows > 0 ? write_column(series, h5, 0, series->counted, rows) : NSDAE_OK;
  if (status < 0) return status;
  memmove(series->buffer[0], series->buffer[0] + rows * series->bytes[0],
          series->held * series->bytes[0]);
  series->counted = series->written;
  return NSDAE_OK;
}

int nsdae_series_is_full(const nsdae_series *series)
{
  return series->table->counts &&
         nsdae_series_rows(series) - series->counted == NSDAE_SERIES_ROWS_MAX;
}

/* ---- appending */

int nsdae_series_append(nsdae_series *series, const void *row, int from, int rows)
{
  hsize_t uncounted = nsdae_series_rows(series) - series->counted;
  hsize_t room = series->chunk - nsdae_series_rows(series) % series->chunk;
  hsize_t count = (hsize_t)rows < room ? (hsize_t)rows : room;
  for (int i = 0; i < series->table->columns; i++) {
    const nsdae_column *column = &series->table->column[i];
    const char *field = (const char *)row + column->offset;
    size_t bytes = series->bytes[i], at = i < first_written(series) ? uncounted : series->held;
    if (bytes == 0) continue;
    if (column->pointer) field = *(const char *const *)(const void *)field;
    memcpy(series->buffer[i] + at * bytes, field + (size_t)from * bytes, count * bytes);
  }
  series->held += count;
  return (int)count;
}

long nsdae_series_held_bytes(const nsdae_series *series)
{
  enum { TREE_BYTES = 3 * 4096 }; /* nodes that a chunk may need */
  hsize_t uncounted = nsdae_series_rows(series) - series->counted;
  long bytes = 0;
  for (int i = 0; i < series->table->columns; i++) {
    hsize_t rows = i < first_written(series) ? uncounted : series->held;
    long chunks = rows > 0 ? (long)(rows / series->chunk) + 2 : 0;
    if (series->bytes[i] > 0)
      bytes += chunks * (long)(series->bytes[i] * series->chunk + TREE_BYTES);
  }
  return bytes;
}

void nsdae_series_close(nsdae_series *series)
{
  if (!series->set) return;
  for (int i = 0; i < series->table->columns; i++) {
    if (series->set[i] >= 0) H5Dclose(series->set[i]);
    series->set[i] = -1;
  }
}
