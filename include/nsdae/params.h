/* nsdae: tables that describe the fields of a struct. BSD-3-Clause.
 *
 * One table defines defaults, ranges, set-by-key, printing and HDF5 attributes. The library's
 * options and the parameters of a user's model use the same tables. */
#ifndef NSDAE_PARAMS_H
#define NSDAE_PARAMS_H

#include <stddef.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Type of a field. */
enum nsdae_param_type {
  NSDAE_PARAM_REAL,   /* double */
  NSDAE_PARAM_INT,    /* int */
  NSDAE_PARAM_CHOICE, /* int, index into choices */
  NSDAE_PARAM_TEXT    /* char[NSDAE_PARAM_TEXT_SIZE] */
};

enum { NSDAE_PARAM_TEXT_SIZE = 256 };

/* Flags of a range: lower bound excluded, upper bound excluded, zero allowed in addition. */
enum { NSDAE_OPEN_MIN = 1, NSDAE_OPEN_MAX = 2, NSDAE_OR_ZERO = 4 };

/* One field of a struct. */
typedef struct nsdae_param {
  const char *key;  /* name */
  const char *unit; /* "s", "kg", ...; "1" for a dimensionless number; "" if not applicable */
  const char *help; /* description, one line */
  enum nsdae_param_type type; /* of the field */
  size_t offset;              /* offsetof the field */
  double initial;             /* default; of a choice its index */
  double min, max;            /* range */
  int open;                   /* NSDAE_OPEN_MIN | NSDAE_OPEN_MAX | NSDAE_OR_ZERO */
  const char *const *choices; /* [number of choices + 1], ends with NULL; for NSDAE_PARAM_CHOICE.
                                 Hyphens of a choice may be given as underscores. Of a number with
                                 NSDAE_OR_ZERO: the word for zero, or NULL */
} nsdae_param;

/* A table of n entries for one struct. */
typedef struct nsdae_params {
  const nsdae_param *entry; /* [n] */
  int n;                    /* >= 0 */
} nsdae_params;

/* Sets all fields of the struct at base to their defaults. */
NSDAE_API void nsdae_params_default(const nsdae_params *table, void *base);

/* Sets one field from text.
 *
 * - NSDAE_E_OPTION: no such key (the text suggests the nearest one) or no such choice
 * - NSDAE_E_ARGUMENT: not a number, or out of range; the field is unchanged */
NSDAE_API int nsdae_params_set(const nsdae_params *table, void *base, const char *key,
                               const char *value, nsdae_error *error);

/* Checks every field against its range. NSDAE_E_ARGUMENT: the text names the first field out of
 * range. */
NSDAE_API int nsdae_params_check(const nsdae_params *table, const void *base, nsdae_error *error);

/* Entry of a key, or NULL. */
NSDAE_API const nsdae_param *nsdae_params_find(const nsdae_params *table, const char *key);

/* Writes the value of a field as text. nsdae_params_set reads the text back to the same value. The
 * text is empty if param or base is NULL, or the field has the index of no choice. */
NSDAE_API void nsdae_params_format(const nsdae_param *param, const void *base, char *text,
                                   size_t size);

/* Writes the range as text, at most size - 1 characters. Examples: "greater than 0", "at least 1
 * and at most 5", "a finite number". For a choice the text lists its names, "a, b or c"; for a text
 * it is empty. */
NSDAE_API void nsdae_params_range(const nsdae_param *param, char *text, size_t size);

/* The entry of names (ends with NULL) nearest to word by edit distance. Leading dashes are ignored,
 * and a prefix has distance one. NULL if more than half of the word's letters would change. */
NSDAE_API const char *nsdae_suggest_name(const char *word, const char *const *names);

#ifdef __cplusplus
}
#endif
#endif
