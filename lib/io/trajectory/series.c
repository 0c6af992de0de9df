#include "series.h"

#include <stdlib.h>
#include <string.h>

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

void nsdae_series_create(nsdae_series *series, nsdae_h5 *h5, const nsdae_sizes *sizes,
                         const hid_t axes[NSDAE_AXES], const char *scale, int deflate)
{
  for (int i = 0; i < series->table->columns && h5->status == NSDAE_OK; i++) {
    const nsdae_column *column = &series->table->column[i];
    int shape[2], rank = nsdae_width_shape(column->width, sizes, shape);
    nsdae_h5_layout layout = {
        .rank = rank + 1, .most = {H5S_UNLIMITED}, .chunk = {series->chunk}, .deflate = deflate};
    if (series->bytes[i] == 0) continue;
    for (int d = 0; d < rank; d++)
      layout.size[d + 1] = layout.most[d + 1] = layout.chunk[d + 1] = (hsize_t)shape[d];
    series->set[i] = nsdae_h5_dataset(h5, column->path, value_type(column), &layout, column->units,
                                      column->description);
    if (i == 0)
      nsdae_h5_make_scale(h5, series->set[0], scale);
    else
      nsdae_h5_attach_scale(h5, series->set[i], series->set[0], 0);
    for (int d = 0; d < rank; d++)
      nsdae_h5_attach_scale(h5, series->set[i], nsdae_axes_of(axes, column->width, d), d + 1);
  }
}

hsize_t nsdae_series_open(nsdae_series *series, nsdae_h5 *h5, const nsdae_sizes *sizes)
{
  hsize_t rows = (hsize_t)-1;
  for (int i = 0; i < series->table->columns; i++) {
    const nsdae_column *column = &series->table->column[i];
    int shape[2], rank = nsdae_width_shape(column->width, sizes, shape);
    hsize_t length[NSDAE_H5_RANK] = {0, 1, 1};
    if (series->bytes[i] == 0) continue;
    nsdae_h5_shape(h5, column->path, rank + 1, length);
    if (length[1] != (hsize_t)shape[0] || length[2] != (hsize_t)shape[1])
      nsdae_h5_refuse(h5, "resume", "%s has rows of another length", column->path);
    series->set[i] = nsdae_h5_open_dataset(h5, column->path);
    if (length[0] < rows) rows = length[0];
  }
  return rows;
}

void nsdae_series_resume(nsdae_series *series, hsize_t rows)
{
  series->written = rows;
  series->counted = series->table->counts ? rows : 0;
  series->held = 0;
}

void nsdae_series_cut(nsdae_series *series, nsdae_h5 *h5)
{
  int first = first_written(series);
  if (first == 1) {
    nsdae_h5_cut(h5, series->set[0], series->counted);
    nsdae_h5_flush(h5);
  }
  for (int i = first; i < series->table->columns; i++)
    if (series->set[i] >= 0) nsdae_h5_cut(h5, series->set[i], series->written);
}

/* ---- writing */

static void write_column(nsdae_series *series, nsdae_h5 *h5, int i, hsize_t from, hsize_t rows)
{
  if (series->set[i] >= 0 && rows > 0)
    nsdae_h5_append(h5, series->set[i], value_type(&series->table->column[i]), from, rows,
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

void nsdae_series_rewind(nsdae_series *series, hsize_t rows)
{
  if (rows < series->written) series->written = rows;
  if (rows < series->counted) series->counted = rows;
  series->held = rows - series->written;
}

void nsdae_series_write(nsdae_series *series, nsdae_h5 *h5, nsdae_series_part part)
{
  if (series->packed && part == NSDAE_SERIES_CHUNKS && !nsdae_series_ends_chunk(series)) return;
  for (int i = first_written(series); i < series->table->columns; i++)
    write_column(series, h5, i, series->written, series->held);
  if (h5->status < 0) return;
  series->written += series->held;
  series->held = 0;
}

void nsdae_series_count(nsdae_series *series, nsdae_h5 *h5)
{
  if (!series->table->counts) return;
  hsize_t rows = series->written - series->counted;
  write_column(series, h5, 0, series->counted, rows);
  if (h5->status < 0) return;
  memmove(series->buffer[0], series->buffer[0] + rows * series->bytes[0],
          series->held * series->bytes[0]);
  series->counted = series->written;
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
