#include "series.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "system_impl.h"

/* A chunk of a column is at most so long, unless a row is longer: what is kept of a large system's
 * records is bounded by it, and 1024 rows of most systems are less. */
static const size_t chunk_bytes = (size_t)4 << 20;

/* ---- rows and chunks */

static hid_t value_type(const nsdae_series_column *c)
{
  return c->of->value == NSDAE_VALUE_INT    ? H5T_NATIVE_INT
         : c->of->value == NSDAE_VALUE_LONG ? H5T_NATIVE_LONG
                                            : H5T_NATIVE_DOUBLE;
}

/* Columns before it count rows and are written at flushes. */
static int first_written(const nsdae_series *series)
{
  return series->table->counts ? 1 : 0;
}

int nsdae_series_init(nsdae_series *series, const nsdae_table *table, const nsdae_sizes *sizes,
                      int compress)
{
  static const size_t size[] = {[NSDAE_VALUE_REAL] = sizeof(double),
                                [NSDAE_VALUE_INT] = sizeof(int),
                                [NSDAE_VALUE_LONG] = sizeof(long)};
  size_t widest = 1, rows = (size_t)nsdae_table_chunk(table, sizes);
  *series = (nsdae_series){.table = table, .deflate = table->packed ? compress : 0};
  series->column = calloc((size_t)table->columns, sizeof *series->column);
  if (!series->column) return NSDAE_E_MEMORY;
  for (int i = 0; i < table->columns; i++) {
    nsdae_series_column *c = &series->column[series->columns];
    *c = (nsdae_series_column){.of = &table->column[i], .set = -1};
    c->rank = nsdae_table_shape(table, c->of->width, sizes, c->shape, c->axis);
    c->bytes = size[c->of->value] * (size_t)c->shape[0] * (size_t)c->shape[1];
    if (c->bytes > widest) widest = c->bytes;
    if (c->bytes > 0) series->columns++;
  }
  while (rows > 1 && widest > chunk_bytes / rows) rows /= 2;
  series->chunk = rows;
  for (int i = 0; i < series->columns; i++) {
    nsdae_series_column *c = &series->column[i];
    c->buffer = malloc(c->bytes * (i < first_written(series) ? NSDAE_SERIES_ROWS_MAX : rows));
    if (!c->buffer) return NSDAE_E_MEMORY;
  }
  return NSDAE_OK;
}

void nsdae_series_release(nsdae_series *series)
{
  for (int i = 0; i < series->columns; i++) free(series->column[i].buffer);
  free(series->column);
  *series = (nsdae_series){0};
}

/* ---- creating and opening */

enum { UNITS_SIZE = 32 };

/* The units "A|B" of a column are A, B or "A, B", as its contacts or frictional joints are. */
static const char *units_of(const nsdae_column *c, const nsdae_system *s, char text[UNITS_SIZE])
{
  const char *other = strchr(c->units, '|');
  if (!other) return c->units;
  int joints = c->width == NSDAE_WIDTH_F, count = joints ? s->dims.f : s->dims.k, turns = 0;
  int kind = joints ? NSDAE_NAME_FRICTIONAL_JOINT : NSDAE_NAME_CONTACT;
  for (int i = 0; i < count; i++) turns += strcmp(nsdae_system_get_unit(s, kind, i), "rad") == 0;
  if (count > 0 && turns == count) return other + 1;
  int both =
      turns > 0 || (!joints && s->maker.turns && count == 0); /* in a list they are unknown */
  snprintf(text, UNITS_SIZE, "%.*s%s%s", (int)(other - c->units), c->units, both ? ", " : "",
           both ? other + 1 : "");
  return text;
}

void nsdae_series_create(nsdae_series *series, nsdae_h5 *h5, const nsdae_system *system,
                         const hid_t axes[NSDAE_AXES], hid_t rows)
{
  char units[UNITS_SIZE];
  for (int i = 0; i < series->columns; i++) {
    nsdae_series_column *c = &series->column[i];
    nsdae_h5_layout layout = {.rank = c->rank + 1,
                              .most = {H5S_UNLIMITED},
                              .chunk = {series->chunk},
                              .deflate = series->deflate};
    for (int d = 0; d < c->rank; d++)
      layout.size[d + 1] = layout.most[d + 1] = layout.chunk[d + 1] = (hsize_t)c->shape[d];
    c->set = nsdae_h5_dataset(h5, c->of->path, value_type(c), &layout,
                              units_of(c->of, system, units), c->of->description);
    if (i == 0 && rows < 0)
      nsdae_h5_make_scale(h5, c->set, series->table->scale);
    else
      nsdae_h5_attach_scale(h5, c->set, rows < 0 ? series->column[0].set : rows, 0);
    for (int d = 0; d < c->rank; d++) nsdae_h5_attach_scale(h5, c->set, axes[c->axis[d]], d + 1);
  }
}

hsize_t nsdae_series_open(nsdae_series *series, nsdae_h5 *h5)
{
  hsize_t rows = (hsize_t)-1;
  for (int i = 0; i < series->columns; i++) {
    nsdae_series_column *c = &series->column[i];
    hsize_t length[NSDAE_H5_RANK] = {0, 1, 1};
    if (!nsdae_h5_has(h5, c->of->path))
      nsdae_h5_refuse(h5, "resume",
                      "it has no %s, because another version of the library wrote it: "
                      "start the run again, with another file",
                      c->of->path);
    nsdae_h5_shape(h5, c->of->path, c->rank + 1, length);
    if (length[1] != (hsize_t)c->shape[0] || length[2] != (hsize_t)c->shape[1])
      nsdae_h5_refuse(h5, "resume", "%s has rows of another length", c->of->path);
    c->set = nsdae_h5_open_dataset(h5, c->of->path);
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
    nsdae_h5_cut(h5, series->column[0].set, series->counted);
    nsdae_h5_flush(h5);
  }
  for (int i = first; i < series->columns; i++)
    nsdae_h5_cut(h5, series->column[i].set, series->written);
}

/* ---- writing */

static void write_column(const nsdae_series_column *c, nsdae_h5 *h5, hsize_t from, hsize_t rows)
{
  if (rows > 0) nsdae_h5_append(h5, c->set, value_type(c), from, rows, c->buffer);
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
  int whole = part == NSDAE_SERIES_CHUNKS && series->deflate > 0;
  if (whole && !nsdae_series_ends_chunk(series)) return;
  for (int i = first_written(series); i < series->columns; i++)
    write_column(&series->column[i], h5, series->written, series->held);
  if (h5->status < 0) return;
  series->written += series->held;
  series->held = 0;
}

void nsdae_series_count(nsdae_series *series, nsdae_h5 *h5)
{
  nsdae_series_column *c = series->column;
  hsize_t rows = series->written - series->counted;
  if (!series->table->counts) return;
  write_column(c, h5, series->counted, rows);
  if (h5->status < 0) return;
  memmove(c->buffer, c->buffer + rows * c->bytes, series->held * c->bytes);
  series->counted = series->written;
}

int nsdae_series_is_full(const nsdae_series *series)
{
  return series->table->counts &&
         nsdae_series_rows(series) - series->counted == NSDAE_SERIES_ROWS_MAX;
}

/* ---- appending */

int nsdae_series_append(nsdae_series *series, const nsdae_row *row, int from, int rows)
{
  hsize_t uncounted = nsdae_series_rows(series) - series->counted;
  hsize_t room = series->chunk - nsdae_series_rows(series) % series->chunk;
  hsize_t count = (hsize_t)rows < room ? (hsize_t)rows : room;
  for (int i = 0; i < series->columns; i++) {
    const nsdae_series_column *c = &series->column[i];
    const char *field = (const char *)row + c->of->offset;
    size_t at = i < first_written(series) ? uncounted : series->held;
    if (c->of->pointer) field = *(const char *const *)(const void *)field;
    memcpy(c->buffer + at * c->bytes, field + (size_t)from * c->bytes, count * c->bytes);
  }
  series->held += count;
  return (int)count;
}

long nsdae_series_held_bytes(const nsdae_series *series)
{
  enum { TREE_BYTES = 3 * 4096 }; /* nodes that a chunk may need */
  hsize_t uncounted = nsdae_series_rows(series) - series->counted;
  long bytes = 0;
  for (int i = 0; i < series->columns; i++) {
    hsize_t rows = i < first_written(series) ? uncounted : series->held;
    long chunks = rows > 0 ? (long)(rows / series->chunk) + 2 : 0;
    bytes += chunks * (long)(series->column[i].bytes * series->chunk + TREE_BYTES);
  }
  return bytes;
}

/* ---- axes */

static const struct axis {
  const char *path;   /* the dimension has the dataset's name */
  const char *letter; /* name of number i where it has none: q0, v0, ... */
  const char *what;
  int kind;              /* enum nsdae_name_kind, or -1 */
  const char *unit_path; /* NULL: of the file's own */
} axis[NSDAE_AXES] = {
    [NSDAE_WIDTH_Q] = {"/coordinate", "q", "names of the coordinates", NSDAE_NAME_COORDINATE,
                       "/coordinate_unit"},
    [NSDAE_WIDTH_V] = {"/velocity", "v", "names of the velocities", NSDAE_NAME_VELOCITY,
                       "/velocity_unit"},
    [NSDAE_WIDTH_M] = {"/constraint", "constraint", "names of the constraints",
                       NSDAE_NAME_CONSTRAINT, "/constraint_unit"},
    [NSDAE_WIDTH_K] = {"/contacts/contact", "contact", "names of the contacts", NSDAE_NAME_CONTACT,
                       "/contacts/contact_unit"},
    [NSDAE_WIDTH_T] = {"/tangent", "tangent", "tangential directions of a contact", -1, NULL},
    [NSDAE_WIDTH_F] = {"/frictional_joint/frictional_joint", "frictional_joint",
                       "names of the frictional joints", NSDAE_NAME_FRICTIONAL_JOINT,
                       "/frictional_joint/frictional_joint_unit"},
    [NSDAE_WIDTH_PAIR] = {"/side", "side", "sides of a contact", -1, NULL},
    [NSDAE_WIDTH_TWO] = {"/component2", "component", "x, y of a sensor in the plane", -1, NULL},
    [NSDAE_WIDTH_THREE] = {"/component3", "component", "x, y, z", -1, NULL},
    [NSDAE_WIDTH_FOUR] = {"/component4", "component", "w, x, y, z of a quaternion", -1, NULL},
};

/* Past this number, one that has no name is its number: a text each costs more than the data. */
enum { NAMED_MOST = 4096, NAME_SIZE = 64 };

/* The names of axis i, or their units, as a dataset of n texts. */
static void write_texts(nsdae_h5 *h5, const nsdae_system *system, int i, int n, int units)
{
  const struct axis *a = &axis[i];
  char **text = nsdae_h5_allocate(h5, (size_t)n, sizeof *text + NAME_SIZE);
  for (int j = 0; text && j < n; j++) {
    const char *given = units         ? nsdae_system_get_unit(system, a->kind, j)
                        : a->kind < 0 ? ""
                                      : nsdae_system_get_name(system, a->kind, j);
    text[j] = (char *)(text + n) + (size_t)j * NAME_SIZE;
    if (units || *given)
      snprintf(text[j], NAME_SIZE, "%s", given);
    else
      snprintf(text[j], NAME_SIZE, "%s%d", a->letter, j);
  }
  nsdae_h5_vector(h5, units ? a->unit_path : a->path, H5T_C_S1, (hsize_t)n, text, "",
                  units ? "units of these" : a->what);
  free(text);
}

static void write_numbers(nsdae_h5 *h5, int i, int n)
{
  int *number = nsdae_h5_allocate(h5, (size_t)n, sizeof *number);
  for (int j = 0; number && j < n; j++) number[j] = j;
  nsdae_h5_vector(h5, axis[i].path, H5T_NATIVE_INT, (hsize_t)n, number, "1", axis[i].what);
  free(number);
}

void nsdae_axes_create(hid_t scale[NSDAE_AXES], nsdae_h5 *h5, const nsdae_system *system,
                       const nsdae_sizes *sizes)
{
  for (int i = 0; i < NSDAE_AXES; i++) {
    int n = sizes->axis[i];
    scale[i] = -1;
    if (n == 0) continue;
    if (n > NAMED_MOST)
      write_numbers(h5, i, n);
    else
      write_texts(h5, system, i, n, 0);
    scale[i] = nsdae_h5_open_dataset(h5, axis[i].path);
    nsdae_h5_make_scale(h5, scale[i], strrchr(axis[i].path, '/') + 1);
    if (!axis[i].unit_path || n > NAMED_MOST) continue;
    /* the units beside the names, with the names as their dimension */
    write_texts(h5, system, i, n, 1);
    hid_t set = nsdae_h5_open_dataset(h5, axis[i].unit_path);
    nsdae_h5_attach_scale(h5, set, scale[i], 0);
    if (set >= 0) H5Dclose(set);
  }
}
