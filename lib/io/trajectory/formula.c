/* A reader by recursive descent over brackets and calls. It stops at the first reason and gives it
 * on; blanks may stand between any two symbols. */
#include "formula.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "words.h"

typedef struct reader {
  const char *text, *at;
  const nsdae_formula_names *names;
  char *reason;
} reader;

typedef struct function {
  const char *name;
  int arguments;
} function;

static const function functions[] = {
    {"sin", 1},  {"cos", 1}, {"tan", 1}, {"asin", 1}, {"acos", 1}, {"atan", 1}, {"atan2", 2},
    {"sqrt", 1}, {"exp", 1}, {"log", 1}, {"abs", 1},  {"min", 2},  {"max", 2},  {"hypot", 2},
};

enum { FUNCTIONS = sizeof functions / sizeof *functions };

/* The alphabet is ASCII whatever the locale. */
#define DIGITS  "0123456789"
#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"

static int is_digit(char c)
{
  return c && strchr(DIGITS, c);
}

static int refuse_formula(reader *r, const char *format, ...) NSDAE_PRINTF(2, 3);

static int refuse_formula(reader *r, const char *format, ...)
{
  va_list args;
  va_start(args, format);
  int used = vsnprintf(r->reason, NSDAE_FORMULA_REASON, format, args);
  va_end(args);
  if (used > 0 && used < NSDAE_FORMULA_REASON)
    snprintf(r->reason + used, (size_t)(NSDAE_FORMULA_REASON - used), " at character %d",
             (int)(r->at - r->text) + 1);
  return NSDAE_E_ARGUMENT;
}

/* ---- symbols */

/* The next symbol's first character. */
static char next(reader *r)
{
  while (*r->at == ' ') r->at++;
  return *r->at;
}

/* Whether it is one of these, which is then read. */
static int take(reader *r, const char *symbols)
{
  if (!next(r) || !strchr(symbols, *r->at)) return 0;
  r->at++;
  return 1;
}

static int read_sum(reader *r);

static void skip_digits(reader *r)
{
  r->at += strspn(r->at, DIGITS);
}

/* 12, 1.5, .5, 2e-3 */
static int read_number(reader *r)
{
  const char *from = r->at;
  skip_digits(r);
  if (*r->at == '.') r->at++;
  skip_digits(r);
  if (r->at - from == 1 && *from == '.') return refuse_formula(r, "a point without digits");
  if (*r->at != 'e' && *r->at != 'E') return NSDAE_OK;
  r->at++;
  if (*r->at == '+' || *r->at == '-') r->at++;
  if (!is_digit(*r->at)) return refuse_formula(r, "an exponent without digits");
  skip_digits(r);
  return NSDAE_OK;
}

/* ---- names */

/* q and digits only. */
static int is_column(const char *name)
{
  size_t digits = strspn(name + 1, DIGITS);
  return name[0] == 'q' && digits > 0 && name[1 + digits] == '\0';
}

static int is_numeric(const nsdae_param *p)
{
  return p->type == NSDAE_PARAM_REAL || p->type == NSDAE_PARAM_INT;
}

int nsdae_named_order(const void *a, const void *b)
{
  const nsdae_named *x = a, *y = b;
  int order = strcmp(x->name, y->name);
  return order ? order : (x->number > y->number) - (x->number < y->number);
}

static int compare_names(const void *name, const void *coordinate)
{
  return strcmp(name, ((const nsdae_named *)coordinate)->name);
}

static int find_coordinate(const nsdae_formula_names *n, const char *name)
{
  if (n->named == 0) return -1;
  const nsdae_named *found =
      bsearch(name, n->coordinate, (size_t)n->named, sizeof *found, compare_names);
  return found ? found->number : -1;
}

int nsdae_formula_coordinate(const char *text, const nsdae_formula_names *names)
{
  if (!*text) return -1;
  if (!is_column(text)) return find_coordinate(names, text);
  return strlen(text) < 10 && atoi(text + 1) < names->nq ? atoi(text + 1) : -1;
}

static int is_quantity(const nsdae_formula_names *n, const char *name)
{
  if (strcmp(name, "pi") == 0 || strcmp(name, "t") == 0) return 1;
  if (nsdae_formula_coordinate(name, n) >= 0) return 1;
  const nsdae_param *p = n->parameters ? nsdae_params_find(n->parameters, name) : NULL;
  return p && is_numeric(p) && !is_column(name);
}

static const char *nearest_to(const nsdae_formula_names *n, const char *name)
{
  nsdae_suggest nearest = nsdae_suggest_start(name);
  for (int i = 0; i < FUNCTIONS; i++) nsdae_suggest_try(&nearest, functions[i].name);
  for (int i = 0; i < n->named; i++) nsdae_suggest_try(&nearest, n->coordinate[i].name);
  for (int i = 0; n->parameters && i < n->parameters->n; i++)
    if (is_numeric(&n->parameters->entry[i]))
      nsdae_suggest_try(&nearest, n->parameters->entry[i].key);
  return nsdae_suggest_end(&nearest);
}

static int check_quantity(reader *r, const char *name)
{
  if (is_quantity(r->names, name)) return NSDAE_OK;
  if (is_column(name))
    return refuse_formula(r, "there is no %.12s: the coordinates are q0 to q%d,", name,
                          r->names->nq - 1);
  const char *near = nearest_to(r->names, name);
  if (near) return refuse_formula(r, "unknown name '%.40s' (did you mean '%.40s'?)", name, near);
  return refuse_formula(r, "unknown name '%.40s'", name);
}

/* ---- grammar */

static int read_call(reader *r, const function *f)
{
  if (!take(r, "(")) return refuse_formula(r, "%s without (", f->name);
  int status = read_sum(r);
  for (int i = 1; i < f->arguments && status == NSDAE_OK; i++)
    status = take(r, ",") ? read_sum(r)
                          : refuse_formula(r, "%s takes %d values,", f->name, f->arguments);
  if (status == NSDAE_OK && !take(r, ")")) status = refuse_formula(r, "%s without )", f->name);
  return status;
}

static int read_name(reader *r)
{
  char name[NSDAE_FORMULA_LENGTH];
  size_t n = strspn(r->at, LETTERS DIGITS);
  memcpy(name, r->at, n);
  name[n] = '\0';
  for (int i = 0; i < FUNCTIONS; i++)
    if (strcmp(name, functions[i].name) == 0) {
      r->at += n;
      return read_call(r, &functions[i]);
    }
  int status = check_quantity(r, name);
  if (status == NSDAE_OK) r->at += n;
  return status;
}

static int read_atom(reader *r)
{
  char c = next(r);
  if (is_digit(c) || c == '.') return read_number(r);
  if (c && strchr(LETTERS, c)) return read_name(r);
  if (c == '\0') return refuse_formula(r, "the formula ends in place of a value,");
  if (!take(r, "(")) return refuse_formula(r, "'%c' in place of a value", c < ' ' ? '?' : c);
  int status = read_sum(r);
  if (status == NSDAE_OK && !take(r, ")")) status = refuse_formula(r, "( without )");
  return status;
}

/* Which operator binds closer does not matter for what is a formula: values with signs, and an
 * operator between two. */
static int read_sum(reader *r)
{
  int status;
  do {
    while (take(r, "+-")) continue;
    status = read_atom(r);
  } while (status == NSDAE_OK && take(r, "+-*/^"));
  return status;
}

int nsdae_formula_check(const char *text, const nsdae_formula_names *names,
                        char reason[NSDAE_FORMULA_REASON])
{
  reader r = {.text = text, .at = text, .names = names, .reason = reason};
  reason[0] = '\0';
  if (strlen(text) >= NSDAE_FORMULA_LENGTH) {
    r.at = text + NSDAE_FORMULA_LENGTH - 1;
    return refuse_formula(&r,
                          "the formula is longer than %d characters:", NSDAE_FORMULA_LENGTH - 1);
  }
  int status = read_sum(&r);
  if (status == NSDAE_OK && next(&r)) status = refuse_formula(&r, "'%c' is not expected", *r.at);
  return status;
}
