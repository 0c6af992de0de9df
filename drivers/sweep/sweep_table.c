#include "sweep_table.h"

#include "hdf5_guard.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <hdf5.h>
#include <hdf5_hl.h>

enum { FORMAT_VERSION = 1, DIMENSIONS_MAX = PLAN_PARAMETERS_MAX + 3, TEXT_MAX = 256 };

struct sweep_table {
  const sweep_plan *plan;
  const sweep_keep *keep;
  char path[4096];
  int file;                     /* descriptor */
  haddr_t at[KEEP_COLUMNS_MAX]; /* offsets of the values of each column */
  haddr_t status_at;            /* and the statuses */
  int *status;                  /* [runs] as the file has them */
  int complete;
};

static int fail(nsdae_error *error, int status, const char *format, ...)
{
  va_list args;
  va_start(args, format);
  vsnprintf(error->text, sizeof error->text, format, args);
  va_end(args);
  return error->status = status;
}

static int fail_io(const sweep_table *t, nsdae_error *error, const char *what)
{
  return fail(error, NSDAE_E_IO, "cannot %s '%.120s': %s", what, t->path,
              errno ? strerror(errno) : "HDF5 failed");
}

/* -------- making the file -------- */

static int set_text(hid_t at, const char *name, const char *text, size_t size)
{
  hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  char padded[TEXT_MAX] = "";
  H5Tset_size(type, size);
  snprintf(padded, sizeof padded, "%s", text);
  hid_t attribute = H5Aexists(at, name) > 0
                        ? H5Aopen(at, name, H5P_DEFAULT)
                        : H5Acreate2(at, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  herr_t failed = H5Awrite(attribute, type, padded);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  return failed < 0;
}

static int describe(hid_t dataset, const char *unit, const char *description)
{
  return set_text(dataset, "units", unit, strlen(unit) + 1) |
         set_text(dataset, "description", description, strlen(description) + 1);
}

/* A dataset whose place in the file is there from the start, without a time stamp. */
static hid_t make(hid_t file, const char *path, hid_t type, int rank, const hsize_t *size,
                  const void *fill)
{
  hid_t space = H5Screate_simple(rank, size, NULL), how = H5Pcreate(H5P_DATASET_CREATE);
  hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  H5Pset_obj_track_times(how, 0);
  H5Pset_alloc_time(how, H5D_ALLOC_TIME_EARLY);
  if (fill) H5Pset_fill_value(how, type, fill);
  if (fill) H5Pset_fill_time(how, H5D_FILL_TIME_ALLOC);
  hid_t made = H5Dcreate2(file, path, type, space, links, how, H5P_DEFAULT);
  H5Pclose(links);
  H5Pclose(how);
  H5Sclose(space);
  return made;
}

/* n numbers, or texts of a common width, as a dimension scale. */
static int make_scale(hid_t file, const char *path, hsize_t n, const double *value,
                      const char *unit, const char *description)
{
  hid_t made = make(file, path, H5T_NATIVE_DOUBLE, 1, &n, NULL);
  int failed = H5Dwrite(made, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) < 0;
  failed |= describe(made, unit, description) | (H5DSset_scale(made, strrchr(path, '/') + 1) < 0);
  H5Dclose(made);
  return failed;
}

static int make_texts(hid_t file, const char *path, hsize_t n, const char *texts, size_t width)
{
  hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, width);
  H5Tset_cset(type, H5T_CSET_UTF8);
  hid_t made = make(file, path, type, 1, &n, NULL);
  int failed = H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) < 0;
  H5Dclose(made);
  H5Tclose(type);
  return failed;
}

static int attach(hid_t file, hid_t dataset, const char *scale, unsigned dimension)
{
  hid_t of = H5Dopen2(file, scale, H5P_DEFAULT);
  int failed = H5DSattach_scale(dataset, of, dimension) < 0;
  H5Dclose(of);
  return failed;
}

enum { WIDTH = NSDAE_NAME_SIZE };

static void name_of(const nsdae_system *system, int kind, int i, char text[WIDTH])
{
  const char *name = nsdae_system_get_name(system, kind, i);
  if (*name)
    snprintf(text, WIDTH, "%s", name);
  else
    snprintf(text, WIDTH, "%c%d", kind == NSDAE_NAME_COORDINATE ? 'q' : 'v', i);
}

static void unit_of(const nsdae_system *system, int kind, int i, char text[WIDTH])
{
  snprintf(text, WIDTH, "%s", nsdae_system_get_unit(system, kind, i));
}

/* A text for each of n coordinates or velocities. */
static int make_list(hid_t file, const char *path, int kind, int n, const nsdae_system *system,
                     void (*write)(const nsdae_system *, int, int, char *))
{
  char *texts = calloc((size_t)n, WIDTH);
  if (!texts) return 1;
  for (int i = 0; i < n; i++) write(system, kind, i, texts + (size_t)i * WIDTH);
  int failed = make_texts(file, path, (hsize_t)n, texts, WIDTH);
  free(texts);
  return failed;
}

/* A scale of names, and a list of their units beside it. */
static int make_names(hid_t file, const char *path, const char *unit_path, int kind, int n,
                      const nsdae_system *system)
{
  int failed = make_list(file, path, kind, n, system, name_of) ||
               make_list(file, unit_path, kind, n, system, unit_of);
  hid_t made = H5Dopen2(file, path, H5P_DEFAULT), units = H5Dopen2(file, unit_path, H5P_DEFAULT);
  failed |= describe(made, "", "names") | (H5DSset_scale(made, path + 1) < 0);
  failed |= describe(units, "", "units of these") | (H5DSattach_scale(units, made, 0) < 0);
  H5Dclose(units);
  H5Dclose(made);
  return failed;
}

/* The unit of a parameter of the model or of an option. */
static const char *unit_of_parameter(const table_about *about, const char *name)
{
  const nsdae_param *p = nsdae_params_find(about->parameters, name);
  if (!p) p = nsdae_params_find(nsdae_sim_options_table(), name);
  return p ? p->unit : "";
}

static int make_axes(hid_t file, const sweep_plan *plan, const table_about *about)
{
  char path[PLAN_NAME_SIZE + 8];
  int failed = 0;
  for (int i = 0; i < plan->parameters; i++) {
    const plan_parameter *p = &plan->parameter[i];
    snprintf(path, sizeof path, "/grid/%s", p->name);
    failed |= make_scale(file, path, (hsize_t)plan->length[p->dimension], p->value,
                         unit_of_parameter(about, p->name),
                         p->drawn ? "values drawn at random" : "values");
  }
  return failed;
}

static int attach_axes(hid_t file, hid_t dataset, const sweep_plan *plan)
{
  char path[PLAN_NAME_SIZE + 8];
  int failed = 0;
  for (int i = 0; i < plan->parameters; i++) {
    snprintf(path, sizeof path, "/grid/%s", plan->parameter[i].name);
    failed |= attach(file, dataset, path, (unsigned)plan->parameter[i].dimension);
  }
  return failed;
}

static int make_column(hid_t file, const sweep_plan *plan, const keep_column *c)
{
  const double nothing = NAN;
  hsize_t size[DIMENSIONS_MAX];
  int rank = plan->dimensions;
  for (int i = 0; i < rank; i++) size[i] = (hsize_t)plan->length[i];
  if (c->rows) size[rank++] = (hsize_t)c->rows;
  if (c->columns) size[rank++] = (hsize_t)c->columns;
  hid_t made = make(file, c->path, H5T_NATIVE_DOUBLE, rank, size, &nothing);
  int failed = made < 0 || describe(made, c->unit, c->description) || attach_axes(file, made, plan);
  if (!failed && c->scale) failed = attach(file, made, c->scale, (unsigned)(rank - 1));
  H5Dclose(made);
  return failed;
}

static int make_status(hid_t file, const sweep_plan *plan)
{
  const int not_done = TABLE_NOT_DONE;
  hsize_t size[DIMENSIONS_MAX];
  for (int i = 0; i < plan->dimensions; i++) size[i] = (hsize_t)plan->length[i];
  hid_t made = make(file, "/status", H5T_NATIVE_INT, plan->dimensions, size, &not_done);
  int failed = made < 0 || attach_axes(file, made, plan) ||
               describe(made, "1", "0 completed, < 0 failed (status of the library), 1 pending");
  H5Dclose(made);
  return failed;
}

static int make_root(hid_t file, const table_about *about)
{
  const int version = FORMAT_VERSION;
  hsize_t length = strlen(about->setting) + 1;
  int failed = set_text(file, "format", "nsdae-sweep", 12) |
               set_text(file, "status", "running", 9) | /* "complete" fits in */
               set_text(file, "library_version", nsdae_version(), strlen(nsdae_version()) + 1) |
               set_text(file, "model", about->model, strlen(about->model) + 1) |
               set_text(file, "method", about->method, strlen(about->method) + 1) |
               (H5LTset_attribute_int(file, "/", "format_version", &version, 1) < 0);
  hid_t made = make(file, "/setting", H5T_NATIVE_UCHAR, 1, &length, NULL);
  failed |= H5Dwrite(made, H5T_NATIVE_UCHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, about->setting) < 0;
  failed |= describe(made, "1", "settings of the runs, as text");
  H5Dclose(made);
  return failed;
}

static int fill_file(hid_t file, const sweep_table *t, const table_about *about)
{
  int failed = make_root(file, about) || make_axes(file, t->plan, about) ||
               make_names(file, "/coordinate", "/coordinate_unit", NSDAE_NAME_COORDINATE,
                          t->keep->dims.nq, about->system) ||
               make_names(file, "/velocity", "/velocity_unit", NSDAE_NAME_VELOCITY,
                          t->keep->dims.nv, about->system);
  for (int i = 0; i < t->keep->columns && !failed; i++)
    failed = make_column(file, t->plan, &t->keep->column[i]);
  return failed || make_status(file, t->plan);
}

/* Beside its place, and moved there when it is whole. */
static int create(const sweep_table *t, const table_about *about, nsdae_error *error)
{
  char part[sizeof t->path + 8];
  snprintf(part, sizeof part, "%s.part", t->path);
  errno = 0;
  hid_t groups = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_obj_track_times(groups, 0);
  hid_t file = H5Fcreate(part, H5F_ACC_TRUNC, groups, H5P_DEFAULT);
  H5Pclose(groups);
  int failed = file < 0 || fill_file(file, t, about);
  if (file >= 0) failed |= H5Fclose(file) < 0;
  if (!failed && rename(part, t->path) == 0) return NSDAE_OK;
  int status = fail_io(t, error, "write");
  unlink(part);
  return status;
}

/* -------- continuing a sweep -------- */

/* The first line in which the settings differ. */
static int differs(const sweep_table *t, const char *has, const char *wants, nsdae_error *error)
{
  const char *line = has, *other = wants;
  for (; *has && *has == *wants; has++, wants++)
    if (*has == '\n') line = has + 1, other = wants + 1;
  if (*has == *wants) return NSDAE_OK;
  return fail(error, NSDAE_E_ARGUMENT,
              "'%.80s' is the file of another sweep: it has '%.*s', this one '%.*s'; give another "
              "--output, or remove it",
              t->path, (int)strcspn(line, "\n"), line, (int)strcspn(other, "\n"), other);
}

/* A text of one value, cut to size; the file's own may be longer. */
static int get_text(hid_t file, const char *name, char *text, size_t size)
{
  hid_t attribute = H5Aexists(file, name) > 0 ? H5Aopen(file, name, H5P_DEFAULT) : -1;
  if (attribute < 0) return 1;
  hid_t type = H5Tcopy(H5T_C_S1), space = H5Aget_space(attribute);
  int failed = H5Tset_size(type, size) < 0 || H5Sget_simple_extent_npoints(space) != 1 ||
               H5Aread(attribute, type, text) < 0;
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attribute);
  return failed;
}

static int compare(const sweep_table *t, hid_t file, const char *setting, nsdae_error *error)
{
  hsize_t length = 0;
  char format[16] = "";
  int rank = 0;
  if (get_text(file, "format", format, sizeof format) || strcmp(format, "nsdae-sweep") != 0 ||
      H5LTget_dataset_ndims(file, "/setting", &rank) < 0 || rank != 1 ||
      H5LTget_dataset_info(file, "/setting", &length, NULL, NULL) < 0 || length > 1000000)
    return fail(error, NSDAE_E_ARGUMENT,
                "'%.120s' exists and is not a sweep: give another --output, or remove it", t->path);
  char *has = calloc(1, (size_t)length + 1);
  if (!has) return fail(error, NSDAE_E_MEMORY, "out of memory");
  int status = H5LTread_dataset(file, "/setting", H5T_NATIVE_CHAR, has) < 0
                   ? fail_io(t, error, "read")
                   : differs(t, has, setting, error);
  free(has);
  return status;
}

/* The address in the file of a contiguous dataset of count values of size bytes each; its values
 * are read and written in place. */
static haddr_t place_of(hid_t file, const char *path, hsize_t count, size_t size)
{
  hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
  if (dataset < 0) return HADDR_UNDEF;
  hid_t space = H5Dget_space(dataset);
  int fits = H5Sget_simple_extent_npoints(space) == (hssize_t)count &&
             H5Dget_storage_size(dataset) == count * size;
  haddr_t at = fits ? H5Dget_offset(dataset) : HADDR_UNDEF;
  H5Sclose(space);
  H5Dclose(dataset);
  return at;
}

static int read_places(sweep_table *t, hid_t file, nsdae_error *error)
{
  char status[16] = "";
  int lost = 0;
  hsize_t runs = (hsize_t)t->plan->runs;
  for (int i = 0; i < t->keep->columns; i++) {
    const keep_column *c = &t->keep->column[i];
    t->at[i] = place_of(file, c->path, runs * (hsize_t)keep_size(c), sizeof(double));
    lost |= t->at[i] == HADDR_UNDEF;
  }
  lost |= (t->status_at = place_of(file, "/status", runs, sizeof *t->status)) == HADDR_UNDEF;
  lost = lost || H5LTread_dataset_int(file, "/status", t->status) < 0 ||
         get_text(file, "status", status, sizeof status);
  t->complete = strcmp(status, "complete") == 0;
  return lost ? fail(error, NSDAE_E_IO, "'%.120s' is damaged: remove it", t->path) : NSDAE_OK;
}

static int look_at_file(const sweep_table *t, hid_t file, nsdae_error *error)
{
  char reason[NSDAE_GUARD_REASON] = "";
  hsize_t length = 0;
  if (H5Fget_filesize(file, &length) >= 0 && nsdae_h5_guard(file, length, reason) >= 0)
    return NSDAE_OK;
  return fail(error, NSDAE_E_IO, "cannot read '%.90s': %s", t->path,
              *reason ? reason : "it is damaged");
}

static int take_up(sweep_table *t, const char *setting, nsdae_error *error)
{
  struct stat found;
  errno = 0;
  /* of a pipe HDF5 waits for a writer */
  int regular = stat(t->path, &found) == 0 && S_ISREG(found.st_mode);
  hid_t file = regular ? H5Fopen(t->path, H5F_ACC_RDONLY, H5P_DEFAULT) : H5I_INVALID_HID;
  if (file < 0)
    return fail(error, NSDAE_E_IO, "'%.120s' exists and cannot be read as HDF5", t->path);
  int status = look_at_file(t, file, error);
  if (status == NSDAE_OK) status = compare(t, file, setting, error);
  if (status == NSDAE_OK) status = read_places(t, file, error);
  H5Fclose(file);
  return status;
}

static int open_raw(sweep_table *t, nsdae_error *error)
{
  t->file = open(t->path, O_RDWR | O_CLOEXEC);
  if (t->file < 0) return fail_io(t, error, "open");
  struct flock whole = {.l_type = F_WRLCK,
                        .l_whence = SEEK_SET}; /* HDF5's own are of another kind */
  if (fcntl(t->file, F_SETLK, &whole) == 0) return NSDAE_OK;
  return fail(error, NSDAE_E_IO, "another nsdae-sweep is writing '%.120s'", t->path);
}

/* A file whose last writes failed stays open in HDF5 1.10 with half its structures freed, and
 * HDF5's handler at the exit reads them. All files are closed here: the handler is not needed. */
int table_open(const char *path, const sweep_plan *plan, const sweep_keep *keep,
               const table_about *about, sweep_table **made, nsdae_error *error)
{
  sweep_table *t = *made = calloc(1, sizeof *t);
  if (!t) return fail(error, NSDAE_E_MEMORY, "out of memory");
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  t->plan = plan;
  t->keep = keep;
  t->file = -1;
  snprintf(t->path, sizeof t->path, "%s", path);
  t->status = malloc((size_t)plan->runs * sizeof *t->status);
  if (!t->status) return fail(error, NSDAE_E_MEMORY, "out of memory for %ld runs", plan->runs);
  int status = access(path, F_OK) == 0 ? NSDAE_OK : create(t, about, error);
  if (status == NSDAE_OK) status = take_up(t, about->setting, error);
  return status < 0 ? status : open_raw(t, error);
}

int table_has(const sweep_table *t, long run)
{
  return t->status[run] == NSDAE_OK;
}

int table_complete(const sweep_table *t)
{
  return t->complete;
}

static int write_at(const sweep_table *t, const void *bytes, size_t size, haddr_t at)
{
  const char *from = bytes;
  while (size > 0) {
    ssize_t wrote = pwrite(t->file, from, size, (off_t)at);
    if (wrote < 0 && errno != EINTR) return 1;
    if (wrote <= 0) continue;
    from += wrote;
    at += (haddr_t)wrote;
    size -= (size_t)wrote;
  }
  return 0;
}

int table_put(sweep_table *t, long run, int status, const double *row, nsdae_error *error)
{
  int failed = 0;
  errno = 0;
  for (int i = 0; i < t->keep->columns && !failed; i++) {
    const keep_column *c = &t->keep->column[i];
    size_t size = (size_t)keep_size(c) * sizeof *row;
    failed = write_at(t, row + c->offset, size, t->at[i] + (haddr_t)run * size);
  }
  failed =
      failed || write_at(t, &status, sizeof status, t->status_at + (haddr_t)run * sizeof status);
  return failed ? fail_io(t, error, "write") : NSDAE_OK;
}

static int by_run(const void *a, const void *b)
{
  const table_failure *x = a, *y = b;
  return (x->run > y->run) - (x->run < y->run);
}

static int write_failures(hid_t file, table_failure *failure, long failures)
{
  hsize_t n = (hsize_t)failures;
  long long *run = malloc((size_t)failures * sizeof *run);
  char *reason = calloc((size_t)failures, TABLE_REASON_SIZE);
  int failed = !run || !reason;
  qsort(failure, (size_t)failures, sizeof *failure, by_run);
  for (long i = 0; i < failures && !failed; i++) {
    run[i] = failure[i].run;
    memcpy(reason + i * TABLE_REASON_SIZE, failure[i].reason, TABLE_REASON_SIZE);
  }
  hid_t made = failed ? -1 : make(file, "/failure/run", H5T_NATIVE_LLONG, 1, &n, NULL);
  failed = failed || made < 0 ||
           H5Dwrite(made, H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, run) < 0 ||
           describe(made, "1", "number of the run, from 0; last dimension fastest");
  if (made >= 0) H5Dclose(made);
  failed = failed || make_texts(file, "/failure/reason", n, reason, TABLE_REASON_SIZE);
  free(run);
  free(reason);
  return failed;
}

int table_finish(sweep_table *t, table_failure *failure, long failures, nsdae_error *error)
{
  errno = 0;
  hid_t file = H5Fopen(t->path, H5F_ACC_RDWR, H5P_DEFAULT);
  int failed = file < 0;
  /* of a sweep that was killed right here */
  if (!failed && H5Lexists(file, "/failure", H5P_DEFAULT) > 0)
    failed = H5Ldelete(file, "/failure", H5P_DEFAULT) < 0;
  if (!failed && failures > 0) failed = write_failures(file, failure, failures);
  if (!failed) failed = set_text(file, "status", "complete", 9);
  if (file >= 0) failed |= H5Fclose(file) < 0;
  return failed ? fail_io(t, error, "write") : NSDAE_OK;
}

void table_close(sweep_table **t)
{
  if (!*t) return;
  if ((*t)->file >= 0) close((*t)->file);
  free((*t)->status);
  free(*t);
  *t = NULL;
}
