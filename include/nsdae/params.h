/* nsdae: tables that describe the fields of a struct. BSD-3-Clause.
 *
 * One table drives defaults, ranges, set-by-key, printing and the HDF5 attributes, for the
 * library's own options and for the parameters of a user's model alike. */
#ifndef NSDAE_PARAMS_H
#define NSDAE_PARAMS_H

#include <stddef.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What the field is. */
enum nsdae_param_type {
  NSDAE_PARAM_REAL,   /* double */
  NSDAE_PARAM_INT,    /* int */
  NSDAE_PARAM_CHOICE, /* int, index into choices */
  NSDAE_PARAM_TEXT    /* char[NSDAE_PARAM_TEXT_SIZE] */
};

enum { NSDAE_PARAM_TEXT_SIZE = 256 };

/* Which bound of a range is itself excluded; whether zero is allowed beside the range. */
enum { NSDAE_OPEN_MIN = 1, NSDAE_OPEN_MAX = 2, NSDAE_OR_ZERO = 4 };

/* One field of a struct. */
typedef struct nsdae_param {
  const char *key;  /* its name */
  const char *unit; /* "s", "kg", ...; "1" for a pure number; "" where a unit makes no sense */
  const char *help; /* one line */
  enum nsdae_param_type type; /* of the field */
  size_t offset;              /* offsetof the field */
  double initial;             /* default; of a choice its index */
  double min, max;            /* range */
  int open;                   /* NSDAE_OPEN_MIN | NSDAE_OPEN_MAX | NSDAE_OR_ZERO */
  const char *const *choices; /* ends with NULL; for NSDAE_PARAM_CHOICE */
} nsdae_param;

/* A table of n entries over one struct. */
typedef struct nsdae_params {
  const nsdae_param *entry; /* [n] */
  int n;                    /* >= 0 */
} nsdae_params;

/* Fills the struct at base with the initial values. */
NSDAE_API void nsdae_params_default(const nsdae_params *table, void *base);

/* Sets one field from text. NSDAE_E_OPTION: no such key (the text names the nearest one) or no
 * such choice. NSDAE_E_ARGUMENT: not a number, or outside its range; the field is unchanged. */
NSDAE_API int nsdae_params_set(const nsdae_params *table, void *base, const char *key,
                               const char *value, nsdae_error *error);

/* Tests every field against its range. NSDAE_E_ARGUMENT names the first one outside. */
NSDAE_API int nsdae_params_check(const nsdae_params *table, const void *base, nsdae_error *error);

/* Entry of that key, or NULL. */
NSDAE_API const nsdae_param *nsdae_params_find(const nsdae_params *table, const char *key);

/* Writes the field's value as text that nsdae_params_set reads back to the same value. */
NSDAE_API void nsdae_params_format(const nsdae_param *param, const void *base, char *text,
                                   size_t size);

/* Writes the range in words, at most size - 1 characters of them: "greater than 0", "at least 1 and
 * at most 5", "a finite number"; the names of a choice, "a, b or c"; nothing of a text. */
NSDAE_API void nsdae_params_range(const nsdae_param *param, char *text, size_t size);

/* The one of names (ends with NULL) nearest to word by edit distance, where leading dashes do not
 * count and a beginning is one change away; NULL where none is near enough (more than half of the
 * word's letters would change). */
NSDAE_API const char *nsdae_suggest_name(const char *word, const char *const *names);

#ifdef __cplusplus
}
#endif
#endif
