/* Tables that describe the fields of a struct: see nsdae/params.h. */
#include <nsdae/params.h>

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "errors.h"
#include "words.h"

static void *field(const nsdae_param *param, void *base)
{
  return (char *)base + param->offset;
}

static double number_at(const nsdae_param *param, const void *base)
{
  const void *at = (const char *)base + param->offset;
  return param->type == NSDAE_PARAM_REAL ? *(const double *)at : (double)*(const int *)at;
}

static void store(const nsdae_param *param, void *base, double value)
{
  if (param->type == NSDAE_PARAM_REAL)
    *(double *)field(param, base) = value;
  else
    *(int *)field(param, base) = (int)value;
}

/* NULL, or what of an entry is NULL though it must not be. */
static const char *missing_of(const nsdae_param *param)
{
  if (!param->key) return "key";
  return param->type == NSDAE_PARAM_CHOICE && !param->choices ? "choices" : NULL;
}

/* NSDAE_OK, or NSDAE_E_ARGUMENT: the entries cannot be read. */
static int check_entries(const nsdae_params *table, const char *where, nsdae_error *error)
{
  if (!table->entry && table->n > 0) return nsdae_error_null(error, where, "table->entry");
  for (int i = 0; i < table->n; i++) {
    const char *missing = missing_of(&table->entry[i]);
    if (missing)
      return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, missing, "%s of entry %d is NULL",
                             missing, i);
  }
  return NSDAE_OK;
}

void nsdae_params_default(const nsdae_params *table, void *base)
{
  if (!table || !table->entry || !base) return;
  for (int i = 0; i < table->n; i++) {
    const nsdae_param *param = &table->entry[i];
    if (param->type == NSDAE_PARAM_TEXT)
      *(char *)field(param, base) = '\0';
    else
      store(param, base, param->initial);
  }
}

const nsdae_param *nsdae_params_find(const nsdae_params *table, const char *key)
{
  if (!table || !table->entry || !key) return NULL;
  for (int i = 0; i < table->n; i++)
    if (table->entry[i].key && strcmp(table->entry[i].key, key) == 0) return &table->entry[i];
  return NULL;
}

static int above_min(const nsdae_param *param, double value)
{
  return param->open & NSDAE_OPEN_MIN ? value > param->min : value >= param->min;
}

static int below_max(const nsdae_param *param, double value)
{
  return param->open & NSDAE_OPEN_MAX ? value < param->max : value <= param->max;
}

/* "a, b or c", with " or " as the last separator */
static void list_choices(const nsdae_param *param, const char *last, char *text, size_t size)
{
  size_t used = 0;
  for (int i = 0; param->choices[i] && used < size; i++) {
    const char *between = i == 0 ? "" : param->choices[i + 1] ? ", " : last;
    used += (size_t)snprintf(text + used, size - used, "%s%s", between, param->choices[i]);
  }
}

/* The word for zero; NULL: none. */
static const char *word_of_zero(const nsdae_param *param)
{
  return param->type != NSDAE_PARAM_CHOICE && param->open & NSDAE_OR_ZERO && param->choices
             ? param->choices[0]
             : NULL;
}

void nsdae_params_range(const nsdae_param *param, char *text, size_t size)
{
  if (!text || size == 0) return;
  text[0] = '\0';
  if (!param || missing_of(param) || param->type == NSDAE_PARAM_TEXT) return;
  const char *low = param->open & NSDAE_OPEN_MIN ? "greater than" : "at least";
  const char *zero = word_of_zero(param),
             *high = param->open & NSDAE_OPEN_MAX ? "less than" : "at most";
  if (param->type == NSDAE_PARAM_CHOICE)
    list_choices(param, " or ", text, size);
  else if (isinf(param->max) && isinf(param->min))
    snprintf(text, size, "a finite number");
  else if (isinf(param->max))
    snprintf(text, size, "%s %g", low, param->min);
  else if (isinf(param->min))
    snprintf(text, size, "%s %g", high, param->max);
  else
    snprintf(text, size, "%s%s%s %g and %s %g", zero ? zero : "",
             !(param->open & NSDAE_OR_ZERO) ? ""
             : zero                         ? ", or "
                                            : "0, or ",
             low, param->min, high, param->max);
}

static int check_number(const nsdae_param *param, double value, nsdae_error *error)
{
  if (value == 0 && param->open & NSDAE_OR_ZERO) return NSDAE_OK;
  if (isinf(value) && value == param->initial) return NSDAE_OK; /* no bound */
  /* written so that NaN fails */
  if (isfinite(value) && above_min(param, value) && below_max(param, value)) return NSDAE_OK;
  int one_bound = !isinf(param->max) != !isinf(param->min);
  const char *finite = one_bound && !isfinite(value) && !isinf(param->initial) ? "finite and " : "";
  char range[96];
  nsdae_params_range(param, range, sizeof range);
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_params", param->key,
                         "%s = %g is outside its range: it must be %s%s", param->key, value, finite,
                         range);
}

int nsdae_params_check(const nsdae_params *table, const void *base, nsdae_error *error)
{
  if (!table || !base)
    return nsdae_error_null(error, "nsdae_params_check", table ? "base" : "table");
  int readable = check_entries(table, "nsdae_params_check", error);
  if (readable < 0) return readable;
  for (int i = 0; i < table->n; i++) {
    const nsdae_param *param = &table->entry[i];
    if (param->type == NSDAE_PARAM_TEXT) continue;
    int status = check_number(param, number_at(param, base), error);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* The entry whose help has the word, or two of its words as one, as "timestep": a quantity may have
 * its symbol as its name, as L for a length. Some word of prose is always half right: fewer letters
 * than `least` may differ. Words of one or two letters are none. */
static const nsdae_param *described(const nsdae_params *table, const char *key, int least)
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyz";
  const nsdae_param *found = NULL;
  for (int i = 0; i < table->n; i++) {
    char pair[64] = "";
    const char *help = table->entry[i].help;
    for (const char *at = help ? help : ""; *(at += strcspn(at, letters));) {
      char word[32] = "";
      size_t length = strspn(at, letters), before = strlen(pair);
      nsdae_suggest nearest = nsdae_suggest_start(key);
      memcpy(word, at, length < sizeof word ? length : sizeof word - 1);
      nsdae_suggest_try(&nearest, word);
      memcpy(pair + before, word, sizeof word); /* behind the word before it */
      if (strcmp(key, pair) == 0) return &table->entry[i];
      memcpy(pair, word, sizeof word);
      at += length;
      if (length < 3 || nearest.distance >= least) continue;
      least = nearest.distance;
      found = &table->entry[i];
    }
  }
  return found;
}

static int unknown_key(const nsdae_params *table, const char *key, nsdae_error *error)
{
  nsdae_suggest nearest = nsdae_suggest_start(key);
  for (int i = 0; i < table->n; i++) nsdae_suggest_try(&nearest, table->entry[i].key);
  const char *name = nsdae_suggest_end(&nearest);
  /* beside a similar name only the word itself counts */
  const nsdae_param *about = described(table, key, name ? 1 : (int)strlen(key) / 3 + 1);
  if (about)
    return nsdae_error_set(error, NSDAE_E_OPTION, "nsdae_params", key,
                           "unknown name '%s'; did you mean '%s' (%s)?", key, about->key,
                           about->help);
  return nsdae_error_set(error, NSDAE_E_OPTION, "nsdae_params", key,
                         name ? "unknown name '%s'; did you mean '%s'?" : "unknown name '%s'", key,
                         name);
}

/* Whether a choice has this name; its hyphens may be given as underscores. */
static int is_named(const char *choice, const char *value)
{
  while (*choice && (*choice == *value || (*choice == '-' && *value == '_'))) choice++, value++;
  return *choice == *value;
}

static int set_choice(const nsdae_param *param, void *base, const char *value, nsdae_error *error)
{
  for (int i = 0; param->choices[i]; i++) {
    if (!is_named(param->choices[i], value)) continue;
    store(param, base, i);
    return NSDAE_OK;
  }
  char all[160] = "";
  list_choices(param, ", ", all, sizeof all);
  const char *near = nsdae_suggest_name(value, param->choices);
  if (!near)
    return nsdae_error_set(error, NSDAE_E_OPTION, "nsdae_params", param->key,
                           "%s has no choice '%s'; choose one of: %s", param->key, value, all);
  return nsdae_error_set(error, NSDAE_E_OPTION, "nsdae_params", param->key,
                         "%s has no choice '%s'; did you mean '%s'? (of: %s)", param->key, value,
                         near, all);
}

static int set_text(const nsdae_param *param, void *base, const char *value, nsdae_error *error)
{
  if (strlen(value) >= NSDAE_PARAM_TEXT_SIZE)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_params", param->key,
                           "%s is longer than %d characters", param->key,
                           NSDAE_PARAM_TEXT_SIZE - 1);
  strcpy(field(param, base), value);
  return NSDAE_OK;
}

static int set_number(const nsdae_param *param, void *base, const char *value, nsdae_error *error)
{
  double number = 0;
  const char *zero = word_of_zero(param);
  if (!(zero && strcmp(value, zero) == 0) && !nsdae_number_read(value, &number))
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_params", param->key,
                           "%s = '%s' is not a number%s%s", param->key, value, zero ? ", nor " : "",
                           zero ? zero : "");
  int whole = number >= INT_MIN && number <= INT_MAX && number == floor(number);
  if (param->type == NSDAE_PARAM_INT && isfinite(number) && !whole)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_params", param->key,
                           "%s = %s is not a whole number", param->key, value);
  int status = check_number(param, number, error);
  if (status == NSDAE_OK) store(param, base, number);
  return status;
}

int nsdae_params_set(const nsdae_params *table, void *base, const char *key, const char *value,
                     nsdae_error *error)
{
  const char *missing = !table ? "table" : !base ? "base" : !key ? "key" : !value ? "value" : NULL;
  nsdae_error_clear(error);
  if (missing) return nsdae_error_null(error, "nsdae_params_set", missing);
  int readable = check_entries(table, "nsdae_params_set", error);
  if (readable < 0) return readable;
  const nsdae_param *param = nsdae_params_find(table, key);
  if (!param) return unknown_key(table, key, error);
  if (param->type == NSDAE_PARAM_CHOICE) return set_choice(param, base, value, error);
  if (param->type == NSDAE_PARAM_TEXT) return set_text(param, base, value, error);
  return set_number(param, base, value, error);
}

/* Nothing if the index is that of no choice. */
static void write_choice(const nsdae_param *param, int index, char *text, size_t size)
{
  for (int i = 0; i <= index && param->choices[i]; i++)
    if (i == index) snprintf(text, size, "%s", param->choices[i]);
}

void nsdae_params_format(const nsdae_param *param, const void *base, char *text, size_t size)
{
  if (!text || size == 0) return;
  text[0] = '\0';
  if (!param || !base || missing_of(param)) return;
  const void *at = (const char *)base + param->offset;
  if (param->type == NSDAE_PARAM_TEXT) {
    snprintf(text, size, "%s", (const char *)at);
    return;
  }
  double value = number_at(param, base);
  const char *zero = word_of_zero(param);
  if (param->type == NSDAE_PARAM_CHOICE)
    write_choice(param, (int)value, text, size);
  else if (zero && value == 0)
    snprintf(text, size, "%s", zero);
  else if (param->type == NSDAE_PARAM_INT)
    snprintf(text, size, "%d", (int)value);
  else
    nsdae_number_write(value, text, size);
}
