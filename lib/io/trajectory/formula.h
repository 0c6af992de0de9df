/* Formulas of the coordinates, which place bodies in a trajectory file. The library only checks
 * them; the programs that draw work them out. */
#ifndef NSDAE_IO_FORMULA_H
#define NSDAE_IO_FORMULA_H

#include <nsdae/params.h>

/* A name, and the number of what has it. */
typedef struct nsdae_named {
  const char *name;
  int number;
} nsdae_named;

/* Of qsort: names in ascending order, of one name the numbers. */
int nsdae_named_order(const void *a, const void *b);

/* What a formula may name besides pi, the time t and the functions: q0 .. q<nq-1>, and these. */
typedef struct nsdae_formula_names {
  int nq, named;
  const nsdae_named *coordinate;  /* [named], the names ascending, each once */
  const nsdae_params *parameters; /* of which the numbers count, or NULL */
} nsdae_formula_names;

/* The number of the coordinate that is all of the text, by its name or as q<number>; -1: the text
 * is something else. */
int nsdae_formula_coordinate(const char *text, const nsdae_formula_names *names);

enum { NSDAE_FORMULA_LENGTH = 256, NSDAE_FORMULA_REASON = 160 };

/* Checks the grammar
 *
 *   sum      product { (+|-) product }
 *   product  sign { (*|/) sign }
 *   sign     (+|-) sign | power
 *   power    atom [ ^ sign ]                      -a^b is -(a^b), a^b^c is a^(b^c)
 *   atom     number | name | name ( sum [, sum] ) | ( sum )
 *
 * with sin cos tan asin acos atan atan2 sqrt exp log abs min max hypot as functions. NSDAE_OK, or
 * NSDAE_E_ARGUMENT with the reason, which begins in small letters and says where. */
int nsdae_formula_check(const char *text, const nsdae_formula_names *names,
                        char reason[NSDAE_FORMULA_REASON]);

#endif
