/* Names and units of what a system has several of. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "callback_guard.h"

static const char *const kinds[NSDAE_NAME_KINDS] = {"coordinate", "velocity",         "constraint",
                                                    "contact",    "frictional joint", "sensor"};

int nsdae_system_count(const nsdae_system *system, int kind)
{
  const nsdae_dims *d = &system->dims;
  const int count[NSDAE_NAME_KINDS] = {d->nq, d->nv, d->m, d->k, d->f, system->maker.sensors.count};
  return kind >= 0 && kind < NSDAE_NAME_KINDS ? count[kind] : 0;
}

/* Why text cannot be a name or unit of less than size bytes; NULL where it can. */
static const char *unfit(const char *text, size_t size)
{
  if (strlen(text) >= size) return "is too long";
  for (; *text; text++)
    if ((unsigned char)*text < ' ' || *text == 0x7f) return "has a control character";
  return NULL;
}

static int refuse_name(nsdae_system *system, const char *argument, const char *text,
                       const char *why)
{
  int name = strcmp(argument, "name") == 0;
  return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, "name", argument,
                             "%s '%.48s' %s: it must be of %s%d bytes, of one line", argument, text,
                             why, name ? "1 .. " : "at most ",
                             (name ? NSDAE_NAME_SIZE : NSDAE_UNIT_SIZE) - 1);
}

static int check_place(nsdae_system *system, const char *setter, int kind, int i, int count)
{
  if (kind < 0 || kind >= NSDAE_NAME_KINDS)
    return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, setter, "kind",
                               "kind = %d is none of enum nsdae_name_kind", kind);
  if (i >= 0 && i < count) return NSDAE_OK;
  return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, setter, "i",
                             count > 0 ? "i = %d is outside its range for a %s: it must be 0 .. %d"
                                       : "i = %d: the system has no %s",
                             i, kinds[kind], count - 1);
}

int nsdae_system_set_name(nsdae_system *system, int kind, int i, const char *name, const char *unit)
{
  if (!system) return NSDAE_E_ARGUMENT;
  if (!unit) unit = "";
  int status = check_place(system, "name", kind, i, nsdae_system_count(system, kind));
  if (status < 0) return status;
  if (!name || !*name) return refuse_name(system, "name", "", name ? "is empty" : "is NULL");
  const char *why = unfit(name, NSDAE_NAME_SIZE), *why_unit = unfit(unit, NSDAE_UNIT_SIZE);
  if (why) return refuse_name(system, "name", name, why);
  if (why_unit) return refuse_name(system, "unit", unit, why_unit);
  status = nsdae_system_open(system, "name");
  if (status < 0) return status;
  if (!system->label[kind])
    system->label[kind] =
        calloc((size_t)nsdae_system_count(system, kind), sizeof *system->label[kind]);
  if (!system->label[kind])
    return nsdae_system_refuse(system, NSDAE_E_MEMORY, "name", "", "out of memory");
  nsdae_label *label = &system->label[kind][i];
  snprintf(label->name, sizeof label->name, "%s", name);
  snprintf(label->unit, sizeof label->unit, "%s", unit);
  snprintf(label->rate, sizeof label->rate, *unit ? "%s/s" : "%s", unit);
  return NSDAE_OK;
}

int nsdae_system_set_size(nsdae_system *system, int kind, int i, double size)
{
  if (!system) return NSDAE_E_ARGUMENT;
  /* of blocks where contacts are by list */
  int blocks = system->by_blocks && kind == NSDAE_NAME_CONTACT && system->dims.k == 0;
  int count = blocks ? system->blocks.count : nsdae_system_count(system, kind),
      status = check_place(system, "size", kind, i, count);
  if (status < 0) return status;
  if (kind != NSDAE_NAME_CONTACT && kind != NSDAE_NAME_CONSTRAINT)
    return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, "size", "kind",
                               "only contacts and constraints have a size");
  if (!(size >= 0) || isinf(size))
    return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, "size", "size",
                               "size = %g is outside its range: it must be at least 0, finite",
                               size);
  status = nsdae_system_open(system, "size");
  if (status < 0) return status;
  double **sizes = &system->size[kind];
  if (!*sizes) *sizes = calloc((size_t)count, sizeof **sizes);
  if (!*sizes) return nsdae_system_refuse(system, NSDAE_E_MEMORY, "size", "", "out of memory");
  (*sizes)[i] = size;
  return NSDAE_OK;
}

/* The label of an item, or NULL where it has none. Velocities are the rates of the coordinates
 * by default: theirs is the coordinate's, and *rate says so. */
static const nsdae_label *find_label(const nsdae_system *system, int kind, int i, int *rate)
{
  *rate = 0;
  if (!system || i < 0 || i >= nsdae_system_count(system, kind)) return NULL;
  const nsdae_label *label = system->label[kind];
  if (label && label[i].name[0]) return &label[i];
  if (kind != NSDAE_NAME_VELOCITY || system->call.kinematics) return NULL;
  *rate = 1;
  return find_label(system, NSDAE_NAME_COORDINATE, i, &(int){0});
}

const char *nsdae_system_get_name(const nsdae_system *system, int kind, int i)
{
  int rate;
  const nsdae_label *label = find_label(system, kind, i, &rate);
  return label ? label->name : "";
}

const char *nsdae_system_get_unit(const nsdae_system *system, int kind, int i)
{
  int rate;
  const nsdae_label *label = find_label(system, kind, i, &rate);
  return !label ? "" : rate ? label->rate : label->unit;
}

/* Appends what the maker calls it, in brackets. */
static const char *append_words(const nsdae_maker *m, int kind, long i,
                                char text[NSDAE_CALLED_SIZE])
{
  char words[NSDAE_CALLED_SIZE];
  size_t used = strlen(text);
  if (m->words && m->words(m->of, kind, i, words, sizeof words))
    snprintf(text + used, NSDAE_CALLED_SIZE - used, " (%.*s)", (int)(sizeof words - used), words);
  return text;
}

const char *nsdae_system_called_id(const nsdae_system *system, long id,
                                   char text[NSDAE_CALLED_SIZE])
{
  snprintf(text, NSDAE_CALLED_SIZE, "contact of id %ld", id);
  return append_words(&system->maker, NSDAE_NAME_CONTACT, id, text);
}

/* Whether number i is a slot with a contact of a list. */
static int in_slot(const nsdae_system *s, int i)
{
  return s && s->tracked && i >= 0 && i < s->dims.k && s->tracked->used[i];
}

int nsdae_system_index(const nsdae_system *system, int kind, int i)
{
  if (kind != NSDAE_NAME_CONTACT || !in_slot(system, i)) return i;
  long id = system->tracked->id[i];
  return id >= 0 && id <= INT_MAX ? (int)id : -1;
}

const char *nsdae_system_called(const nsdae_system *system, int kind, int i,
                                char text[NSDAE_CALLED_SIZE])
{
  if (kind == NSDAE_NAME_CONTACT && in_slot(system, i))
    return nsdae_system_called_id(system, system->tracked->id[i], text);
  const char *name = nsdae_system_get_name(system, kind, i);
  snprintf(text, NSDAE_CALLED_SIZE, *name ? "%s %d \"%s\"" : "%s %d%s", kinds[kind], i, name);
  return system ? append_words(&system->maker, kind, i, text) : text;
}

const char *nsdae_system_called_contact(const nsdae_system *system, const long *id, int i,
                                        char text[NSDAE_CALLED_SIZE])
{
  return system->by_list ? nsdae_system_called_id(system, id[i], text)
                         : nsdae_system_called(system, NSDAE_NAME_CONTACT, i, text);
}

/* 'contact 3 "stop"' behind the text. */
static void append_label(const nsdae_system *system, const nsdae_output *o, int kind, int i,
                         const char *before, nsdae_error *error)
{
  char called[NSDAE_CALLED_SIZE];
  size_t used = strlen(error->text);
  if (kind < 0) return;
  if (o->directions && kind == NSDAE_NAME_CONTACT) i /= system->dims.nt;
  snprintf(error->text + used, sizeof error->text - used, "%s%s", before,
           nsdae_system_called(system, kind, i, called));
}

void nsdae_output_name_entry(const nsdae_system *system, const nsdae_output *output, int row,
                             int column, nsdae_error *error)
{
  append_label(system, output, output->row, row, ": ", error);
  append_label(system, output, output->column, column, output->row < 0 ? ": " : ", ", error);
}

void nsdae_system_name_item(const nsdae_system *system, int kind, int i, nsdae_error *error)
{
  const nsdae_output item = {.row = kind, .column = -1};
  if (!error) return;
  append_label(system, &item, kind, i, ": ", error);
  error->index = nsdae_system_index(system, kind, i);
}

void nsdae_system_name_listed(const nsdae_system *system, long id, nsdae_error *error)
{
  char called[NSDAE_CALLED_SIZE];
  size_t used = error ? strlen(error->text) : 0;
  if (!error) return;
  snprintf(error->text + used, sizeof error->text - used, ": %s",
           nsdae_system_called_id(system, id, called));
}

/* What an output is about: of W_N, its contacts. */
static int about(const nsdae_output *o)
{
  return o->column >= 0 && o->column != NSDAE_NAME_VELOCITY ? o->column : o->row;
}

/* The output of the callback with that number of rows; of differences of it the one that they
 * replace: one of another callback, about the same. Outputs of one size belong to the same. */
static const nsdae_output *find_output(const nsdae_system *system, const nsdae_callback *of,
                                       int rows)
{
  for (int own = 1; own >= 0; own--)
    for (int c = 0; c < nsdae_callbacks_count; c++) {
      const nsdae_callback *callback = &nsdae_callbacks[c];
      if (own && callback != of) continue;
      for (int i = 0; i < callback->outputs; i++)
        if ((own || about(&callback->output[i]) == about(&of->output[0])) &&
            nsdae_output_extent(system, &callback->output[i], callback->output[i].row) == rows)
          return &callback->output[i];
    }
  return NULL;
}

void nsdae_system_name_entry(const nsdae_system *system, const char *callback, int rows, int row,
                             int column, nsdae_error *error)
{
  static const nsdae_output of_joint = {.row = NSDAE_NAME_FRICTIONAL_JOINT, .column = -1};
  const nsdae_callback *c = nsdae_callback_of(callback);
  const nsdae_output *output = error && c ? find_output(system, c, rows) : NULL;
  if (error && strcmp(callback, "joint_friction_rows") == 0) output = &of_joint;
  if (output) nsdae_output_name_entry(system, output, row, column, error);
}

static int by_name(const void *a, const void *b)
{
  const nsdae_label *const *left = a, *const *right = b;
  return strcmp((*left)->name, (*right)->name);
}

int nsdae_names_distinct(const nsdae_system *system, nsdae_error *error)
{
  int status = NSDAE_OK;
  for (int kind = 0; kind < NSDAE_NAME_KINDS && status == NSDAE_OK; kind++) {
    const nsdae_label *label = system->label[kind];
    int count = nsdae_system_count(system, kind), named = 0;
    if (!label) continue;
    const nsdae_label **order = malloc((size_t)count * sizeof *order);
    if (!order) return nsdae_error_memory(error, "nsdae_system");
    for (int i = 0; i < count; i++)
      if (label[i].name[0]) order[named++] = &label[i];
    qsort(order, (size_t)named, sizeof *order, by_name);
    for (int i = 1; i < named && status == NSDAE_OK; i++) {
      int a = (int)(order[i - 1] - label), b = (int)(order[i] - label);
      if (strcmp(label[a].name, label[b].name) != 0) continue;
      status =
          nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_system", "name",
                          "%s %d and %s %d both have the name '%s': names of one kind must differ",
                          kinds[kind], a < b ? a : b, kinds[kind], a < b ? b : a, label[a].name);
    }
    free(order);
  }
  return status;
}

/* What a system knows of the kit that made it: exact derivatives, and names for messages. */

void nsdae_system_set_maker(nsdae_system *system, const nsdae_maker *maker)
{
  system->maker = *maker;
}

int nsdae_system_sensor_size(const nsdae_system *system, int i)
{
  const nsdae_maker *m = system ? &system->maker : NULL;
  return m && i >= 0 && i < m->sensors.count ? m->sensors.size(m->of, i) : 0;
}

int nsdae_system_exact(const nsdae_system *system, int kind, int i)
{
  const nsdae_maker *m = &system->maker;
  return m->exact && m->exact(m->of, kind, i);
}

int nsdae_system_explain(const nsdae_system *system, double t, const double *q, const double *v,
                         nsdae_error *error)
{
  const nsdae_maker *m = &system->maker;
  nsdae_reason reason;
  if (!error || !m->explain || !m->explain(m->of, error->argument, t, q, v, &reason)) return 0;
  const nsdae_error as = *error;
  nsdae_error_set(error, as.status, as.where, reason.element, "%s, at t = %g", reason.text, t);
  error->code = as.code;
  nsdae_error_at(error, as.status, reason.index, t);
  return 1;
}
