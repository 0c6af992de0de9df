#include "run_settings.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "hdf5_read.h"

static const char dataset[] = "/restart/setting";

enum { LINE_SIZE = NSDAE_SETTING_VALUE + 128 };

/* ---- texts of settings */

static int add_setting(nsdae_setting *s, const char *group, const char *key, const char *value)
{
  char line[LINE_SIZE];
  int length = snprintf(line, sizeof line, "%.60s/%.60s=%s", group, key, value);
  for (char *c = line; *c; c++)
    if (iscntrl((unsigned char)*c)) *c = '?';
  size_t room = s->length + (size_t)length + 2;
  if (room > s->room) {
    char *more = realloc(s->text, 2 * room);
    if (!more) return NSDAE_E_MEMORY;
    s->text = more;
    s->room = 2 * room;
  }
  memcpy(s->text + s->length, line, (size_t)length);
  s->length += (size_t)length + 1;
  memcpy(s->text + s->length - 1, "\n", 2);
  return NSDAE_OK;
}

static int add_int(nsdae_setting *s, const char *group, const char *key, int value)
{
  char text[32];
  snprintf(text, sizeof text, "%d", value);
  return add_setting(s, group, key, text);
}

static int add_params(nsdae_setting *s, const char *group, const nsdae_params *table,
                      const void *base)
{
  char value[NSDAE_SETTING_VALUE];
  int status = NSDAE_OK;
  for (int i = 0; table && base && i < table->n && status == NSDAE_OK; i++) {
    nsdae_params_format(&table->entry[i], base, value, sizeof value);
    status = add_setting(s, group, table->entry[i].key, value);
  }
  return status;
}

static int add_sizes(nsdae_setting *s, const nsdae_sim *sim)
{
  nsdae_dims d;
  nsdae_sim_get_dims(sim, &d);
  const struct {
    const char *key;
    int value;
  } size[] = {{"nq", d.nq}, {"nv", d.nv}, {"m", d.m}, {"k", d.k}, {"nt", d.nt}, {"f", d.f}};
  int status = NSDAE_OK;
  for (size_t i = 0; i < sizeof size / sizeof *size && status == NSDAE_OK; i++)
    status = add_int(s, "sizes", size[i].key, size[i].value);
  return status;
}

static int add_run(nsdae_setting *s, const nsdae_trajectory_info *info)
{
  char t_end[32];
  snprintf(t_end, sizeof t_end, "%.17g", info->t_end);
  int status = info->t_end > 0 ? add_setting(s, "run", "t_end", t_end) : NSDAE_OK;
  if (status == NSDAE_OK) status = add_int(s, "run", "every", info->every > 0 ? info->every : 1);
  return status < 0 ? status : add_int(s, "run", "compress", info->compress);
}

/* ---- dataset */

int nsdae_setting_make(nsdae_setting *setting, const nsdae_sim *sim,
                       const nsdae_trajectory_info *info)
{
  nsdae_sim_options options;
  nsdae_sim_get_options(sim, &options);
  *setting = (nsdae_setting){0};
  int status = add_setting(setting, "model", "name", info->model ? info->model : "");
  if (status == NSDAE_OK) status = add_sizes(setting, sim);
  if (status == NSDAE_OK)
    status = add_params(setting, "options", nsdae_sim_options_table(), &options);
  if (status == NSDAE_OK)
    status = add_params(setting, "parameters", info->parameters, info->parameters_base);
  if (status == NSDAE_OK) status = add_run(setting, info);
  if (status < 0) nsdae_setting_release(setting);
  return status;
}

int nsdae_setting_write(const nsdae_setting *setting, nsdae_h5 *h5)
{
  return nsdae_h5_vector(h5, dataset, H5T_NATIVE_UCHAR, (hsize_t)setting->length, setting->text,
                         "1", "settings of the run, as text");
}

int nsdae_setting_read(nsdae_setting *setting, nsdae_h5 *h5)
{
  hsize_t length[1];
  *setting = (nsdae_setting){0};
  if (H5Lexists(h5->file, "/restart", H5P_DEFAULT) == 0)
    return nsdae_error_set(h5->error, NSDAE_E_IO, h5->where ? h5->where : "nsdae_trajectory",
                           "path", "cannot resume '%.90s': a live file has no state", h5->path);
  int status = nsdae_h5_shape(h5, dataset, 1, length);
  if (status < 0) return status;
  setting->length = (size_t)length[0];
  setting->text = calloc(setting->length + 1, 1);
  if (!setting->text) return nsdae_error_memory(h5->error, "nsdae_trajectory");
  status = nsdae_h5_read_as(h5, dataset, H5T_NATIVE_UCHAR, setting->text);
  if (status < 0) nsdae_setting_release(setting);
  return status;
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

static int find_setting(const nsdae_setting *s, const char *name, char value[NSDAE_SETTING_VALUE])
{
  char line[LINE_SIZE], *found;
  const char *at = s->text;
  while (at && next_line(&at, line, &found))
    if (strcmp(line, name) == 0) {
      snprintf(value, NSDAE_SETTING_VALUE, "%.*s", NSDAE_SETTING_VALUE - 1, found);
      return 1;
    }
  return 0;
}

int nsdae_setting_find(const nsdae_setting *setting, const char *group, const char *key,
                       char value[NSDAE_SETTING_VALUE])
{
  char name[128];
  snprintf(name, sizeof name, "%.60s/%.60s", group, key);
  return find_setting(setting, name, value);
}

int nsdae_setting_apply(const nsdae_setting *setting, const char *group, const nsdae_params *table,
                        void *base, nsdae_error *error)
{
  char value[NSDAE_SETTING_VALUE];
  int status = NSDAE_OK;
  for (int i = 0; i < table->n && status == NSDAE_OK; i++)
    if (nsdae_setting_find(setting, group, table->entry[i].key, value))
      status = nsdae_params_set(table, base, table->entry[i].key, value, error);
  return status;
}

static int read_setting(nsdae_setting *setting, nsdae_h5 *h5)
{
  int status = nsdae_h5_open(h5);
  if (status < 0) return status;
  status = nsdae_setting_read(setting, h5);
  nsdae_h5_close(h5);
  return status;
}

int nsdae_trajectory_read_params(const char *path, const char *group, const nsdae_params *table,
                                 void *base, nsdae_error *error)
{
  static const char where[] = "nsdae_trajectory_read_params";
  nsdae_error own;
  nsdae_setting setting;
  int status;
  const char *missing = !path    ? "path"
                        : !group ? "group"
                        : !table ? "table"
                        : !base  ? "base"
                                 : NULL;
  nsdae_error_clear(error);
  if (missing)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, missing, "%s is NULL", missing);
  nsdae_h5 h5 = {.file = -1, .path = path, .where = where, .error = error ? error : &own};
  NSDAE_H5_QUIETLY(status, read_setting(&setting, &h5))
  if (status < 0) return status;
  status = nsdae_setting_apply(&setting, group, table, base, error);
  nsdae_setting_release(&setting);
  return status;
}

/* ---- comparison */

static int differs(const char *name, const char *own, const char *file, const char *path,
                   nsdae_error *error)
{
  const char *key = strchr(name, '/') ? strchr(name, '/') + 1 : name;
  const char *what = strcmp(name, "model/name") == 0 ? "model" : key;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_trajectory_resume", what,
                         "cannot resume '%.90s': it has %.40s %.40s, this run %.40s", path, what,
                         file ? file : "not", own ? own : "not");
}

/* Each line of one is a line of the other. */
static int all_in(const nsdae_setting *one, const nsdae_setting *other, int one_is_file,
                  const char *path, nsdae_error *error)
{
  char line[LINE_SIZE], *value, found[NSDAE_SETTING_VALUE];
  const char *at = one->text;
  while (at && next_line(&at, line, &value)) {
    if (strncmp(line, "run/", 4) == 0) continue;
    const char *there = find_setting(other, line, found) ? found : NULL;
    if (there && strcmp(there, value) == 0) continue;
    return differs(line, one_is_file ? there : value, one_is_file ? value : there, path, error);
  }
  return NSDAE_OK;
}

int nsdae_setting_compare(const nsdae_setting *own, const nsdae_setting *file, const char *path,
                          nsdae_error *error)
{
  int status = all_in(own, file, 0, path, error);
  return status < 0 ? status : all_in(file, own, 1, path, error);
}
