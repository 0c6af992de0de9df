#define _POSIX_C_SOURCE 200809L /* gmtime_r */
#include "description.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- attributes, options, parameters */

enum { FORMAT = 3 }; /* 1 and 2 were those of fixed contacts and contact lists in version 0.2 */

/* Attributes of the root group, which identify the file. */
static void write_root(nsdae_h5 *h5, const char *model, int method)
{
  char created[32];
  struct tm date;
  time_t now = time(NULL);
  strftime(created, sizeof created, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &date)); /* ISO 8601 */
  const char *const text[][2] = {{"format", "nsdae-trajectory"},        {"status", "running"},
                                 {"library_version", nsdae_version()},  {"model", model},
                                 {"method", nsdae_method_name(method)}, {"created", created}};
  nsdae_h5_set_int(h5, h5->file, "format_version", FORMAT);
  for (size_t i = 0; i < sizeof text / sizeof *text; i++)
    nsdae_h5_set_text(h5, h5->file, text[i][0], text[i][1]);
}

/* The fields of a struct that a table describes, as scalar datasets in the group. */
static void write_params(nsdae_h5 *h5, const char *group, const nsdae_params *table,
                         const void *base)
{
  char path[NSDAE_H5_PATH], text[NSDAE_PARAM_TEXT_SIZE];
  const char *const as_text = text;
  nsdae_h5_group(h5, group);
  for (int i = 0; table && base && i < table->n; i++) {
    const nsdae_param *param = &table->entry[i];
    const void *value = (const char *)base + param->offset;
    int is_number = param->type == NSDAE_PARAM_REAL || param->type == NSDAE_PARAM_INT;
    hid_t type = param->type == NSDAE_PARAM_REAL ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT;
    if (!is_number) nsdae_params_format(param, base, text, sizeof text);
    nsdae_h5_array(h5, nsdae_h5_join(path, group, param->key), is_number ? type : H5T_C_S1, 0, NULL,
                   is_number ? value : &as_text, param->unit, param->help);
  }
}

void nsdae_description_write(nsdae_h5 *h5, const nsdae_sim *sim, const nsdae_trajectory_info *info)
{
  nsdae_sim_options options;
  nsdae_sim_get_options(sim, &options);
  write_root(h5, info->model ? info->model : "", options.method);
  write_params(h5, "/options", nsdae_sim_options_table(), &options);
  write_params(h5, "/parameters", info->parameters, info->parameters_base);
}

void nsdae_description_check(nsdae_h5 *h5)
{
  double version = nsdae_h5_get_real(h5, h5->file, "format_version");
  if (h5->status < 0 || version == FORMAT) return;
  nsdae_h5_refuse(h5, "resume",
                  version > 0 && version < FORMAT
                      ? "it was made by version 0.2 (format version %g), whose files can be read "
                        "but not resumed: start the run again, with another file"
                      : "its format version %g is not that of this library",
                  version);
}

void nsdae_description_set_ended(nsdae_h5 *h5, int run_status)
{
  nsdae_h5_set_text(h5, h5->file, "status",
                    run_status == NSDAE_STOPPED         ? "stopped"
                    : run_status >= 0                   ? "complete"
                    : run_status == NSDAE_E_INTERRUPTED ? "interrupted"
                                                        : "failed");
}

static const char dataset[] = "/restart/setting";

enum { LINE_SIZE = NSDAE_SETTING_VALUE + 128 };

/* ---- texts of settings */

static void add_setting(nsdae_setting *s, nsdae_h5 *h5, const char *group, const char *key,
                        const char *format, ...) NSDAE_PRINTF(5, 6);

static void add_setting(nsdae_setting *s, nsdae_h5 *h5, const char *group, const char *key,
                        const char *format, ...)
{
  char line[LINE_SIZE];
  va_list args;
  int start = snprintf(line, sizeof line, "%.60s/%.60s=", group, key);
  va_start(args, format);
  vsnprintf(line + start, sizeof line - (size_t)start, format, args);
  va_end(args);
  for (char *c = line; *c; c++)
    if (iscntrl((unsigned char)*c)) *c = '?';
  size_t length = strlen(line), room = s->length + length + 2;
  if (room > s->room) {
    char *more = realloc(s->text, 2 * room);
    if (!more) nsdae_h5_no_memory(h5);
    if (!more) return;
    s->text = more;
    s->room = 2 * room;
  }
  memcpy(s->text + s->length, line, length);
  s->length += length + 1;
  memcpy(s->text + s->length - 1, "\n", 2);
}

static void add_params(nsdae_setting *s, nsdae_h5 *h5, const char *group, const nsdae_params *table,
                       const void *base)
{
  char value[NSDAE_SETTING_VALUE];
  for (int i = 0; table && base && i < table->n; i++) {
    nsdae_params_format(&table->entry[i], base, value, sizeof value);
    add_setting(s, h5, group, table->entry[i].key, "%s", value);
  }
}

/* ---- dataset */

void nsdae_setting_make(nsdae_setting *setting, nsdae_h5 *h5, const nsdae_sim *sim,
                        const nsdae_trajectory_info *info)
{
  nsdae_sim_options options;
  nsdae_dims d;
  nsdae_sim_get_options(sim, &options);
  nsdae_sim_get_dims(sim, &d);
  const char *const key[] = {"nq", "nv", "m", "k", "nt", "f"};
  const int size[] = {d.nq, d.nv, d.m, d.k, d.nt, d.f};
  *setting = (nsdae_setting){0};
  add_setting(setting, h5, "model", "name", "%s", info->model ? info->model : "");
  for (size_t i = 0; i < sizeof size / sizeof *size; i++)
    add_setting(setting, h5, "sizes", key[i], "%d", size[i]);
  add_params(setting, h5, "options", nsdae_sim_options_table(), &options);
  add_params(setting, h5, "parameters", info->parameters, info->parameters_base);
  if (info->t_end > 0) add_setting(setting, h5, "run", "t_end", "%.17g", info->t_end);
  add_setting(setting, h5, "run", "every", "%d", info->every > 0 ? info->every : 1);
  add_setting(setting, h5, "run", "compress", "%d", info->compress);
  add_setting(setting, h5, "run", "contact_forces", "%d", info->contact_forces);
}

void nsdae_setting_write(const nsdae_setting *setting, nsdae_h5 *h5)
{
  nsdae_h5_vector(h5, dataset, H5T_NATIVE_UCHAR, (hsize_t)setting->length, setting->text, "1",
                  "settings of the run, as text");
}

void nsdae_setting_read(nsdae_setting *setting, nsdae_h5 *h5)
{
  hsize_t length[1] = {0};
  *setting = (nsdae_setting){0};
  if (h5->status < 0) return;
  if (H5Lexists(h5->file, "/restart", H5P_DEFAULT) == 0)
    nsdae_h5_refuse(h5, "resume", "a live file has no state");
  nsdae_h5_shape(h5, dataset, 1, length);
  setting->length = (size_t)length[0];
  setting->text = nsdae_h5_allocate(h5, setting->length, 1);
  nsdae_h5_read(h5, dataset, H5T_NATIVE_UCHAR, setting->text);
}

void nsdae_setting_release(nsdae_setting *setting)
{
  free(setting->text);
  *setting = (nsdae_setting){0};
}

/* ---- reading texts */

/* Takes the line at *at apart; 0 at the end of the text or where it is no such line. */
static int next_line(const char **at, char line[LINE_SIZE], char **value)
{
  size_t length = strcspn(*at, "\n");
  if (length == 0 || length >= LINE_SIZE) return 0;
  memcpy(line, *at, length);
  line[length] = '\0';
  *at += length + ((*at)[length] == '\n');
  *value = strchr(line, '=');
  if (!*value) return 0;
  *(*value)++ = '\0';
  return 1;
}

int nsdae_setting_find(const nsdae_setting *setting, const char *name,
                       char value[NSDAE_SETTING_VALUE])
{
  char line[LINE_SIZE], *found;
  const char *at = setting->text;
  while (at && next_line(&at, line, &found))
    if (strcmp(line, name) == 0) {
      snprintf(value, NSDAE_SETTING_VALUE, "%.*s", NSDAE_SETTING_VALUE - 1, found);
      return 1;
    }
  return 0;
}

/* Sets those of the table's fields that are in the group. */
static int apply(const nsdae_setting *s, const char *group, const nsdae_params *table, void *base,
                 nsdae_error *error)
{
  char name[NSDAE_H5_PATH], value[NSDAE_SETTING_VALUE];
  int status = NSDAE_OK;
  for (int i = 0; i < table->n && status == NSDAE_OK; i++) {
    snprintf(name, sizeof name, "%.60s/%.60s", group, table->entry[i].key); /* as add_setting */
    if (nsdae_setting_find(s, name, value))
      status = nsdae_params_set(table, base, table->entry[i].key, value, error);
  }
  return status;
}

int nsdae_trajectory_read_params(const char *path, const char *group, const nsdae_params *table,
                                 void *base, nsdae_error *error)
{
  static const char where[] = "nsdae_trajectory_read_params";
  nsdae_setting setting;
  const char *missing = !path    ? "path"
                        : !group ? "group"
                        : !table ? "table"
                        : !base  ? "base"
                                 : NULL;
  nsdae_error_clear(error);
  if (missing)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, missing, "%s is NULL", missing);
  nsdae_h5 h5 = {.file = -1, .path = path, .where = where, .error = error};
  int status;
  H5E_BEGIN_TRY
    nsdae_h5_open(&h5);
    nsdae_setting_read(&setting, &h5);
    status = h5.status; /* all is read: how the file closes is no matter */
    nsdae_h5_close(&h5);
  H5E_END_TRY
  if (status == NSDAE_OK) status = apply(&setting, group, table, base, error);
  nsdae_setting_release(&setting);
  return status;
}

/* ---- comparison */

/* Each line of one is a line of the other. */
static void compare_lines(const nsdae_setting *one, const nsdae_setting *other, int one_is_file,
                          nsdae_h5 *h5)
{
  char line[LINE_SIZE], *value, found[NSDAE_SETTING_VALUE];
  const char *at = one->text;
  while (h5->status == NSDAE_OK && next_line(&at, line, &value)) {
    if (strncmp(line, "run/", 4) == 0) continue;
    const char *there = nsdae_setting_find(other, line, found) ? found : NULL;
    if (there && strcmp(there, value) == 0) continue;
    const char *slash = strchr(line, '/'), *key = slash ? slash + 1 : line;
    const char *what = strcmp(line, "model/name") == 0 ? "model" : key;
    const char *in_file = one_is_file ? value : there, *here = one_is_file ? there : value;
    h5->status = nsdae_error_set(h5->error, NSDAE_E_ARGUMENT, h5->where, what,
                                 "cannot resume '%.90s': it has %.40s %.40s, this run %.40s",
                                 h5->path, what, in_file ? in_file : "not", here ? here : "not");
  }
}

void nsdae_setting_compare(const nsdae_setting *own, const nsdae_setting *file, nsdae_h5 *h5)
{
  compare_lines(own, file, 0, h5);
  compare_lines(file, own, 1, h5);
}
