/* nsdae: frictional contact problems in HDF5 files. BSD-3-Clause.
 *
 * The layout is that of FCLIB, the collection of frictional contact problems (Acary, Bremond,
 * Koziara, Perignon, "FCLIB: a collection of discrete 3D frictional contact problems", INRIA
 * RT-444, 2014): /fclib_local with W, V, R, q, s, mu, or /fclib_global with M, H, G, f, w, b, mu,
 * and a solution. What FCLIB has no place for stands beside it, where others do not look: the rows
 * of each contact where they differ (vectors/rows), the compliance (vectors/compliance), the sizes
 * of the blocks of v (blocks), what one double an entry does not hold of a solution
 * (/solution/r_low, of the bilateral rows /solution/l_low, beside r and l); and attributes of the
 * root say where a problem comes from: time [s], step, method, tol, refine. */
#ifndef NSDAE_FRICTION_FILE_H
#define NSDAE_FRICTION_FILE_H

#include <nsdae/friction.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Where a problem comes from. */
typedef struct nsdae_friction_origin {
  double time;        /* [s] */
  long step;          /* that it belongs to, from 1 */
  double tol;         /* bound on the residual, > 0 */
  int refine;         /* as in nsdae_friction_options */
  const char *method; /* its name */
} nsdae_friction_origin;

/* What else is kept with a problem; each may be NULL. */
typedef struct nsdae_friction_points {
  const double *guess; /* m: where the solver began, or is to begin */
  const double *r;     /* m: the solution */
  const double *u;     /* m: its velocities */
  const double *low;   /* m: of a solution in two parts r + low; not looked at without r */
} nsdae_friction_points;

/* A problem as read; the arrays are the file's, and are freed with it. */
typedef struct nsdae_friction_file {
  nsdae_friction_problem problem; /* as read */
  double *guess;                  /* m: the first guess of the file; NULL where there is none */
  double *r;        /* m: its solution; NULL where there is none. Many files have zeros for one */
  double *low;      /* m: what r does not hold of it, as nsdae_friction_solve_twice has it; NULL
                       where there is none */
  double tol;       /* of the attribute; 0 where there is none */
  int refine;       /* the same */
  double asymmetry; /* of W, or M, in the file: max |W_ij - W_ji| / max |W_ij|, 0 where that is
                       rounding. Where it is not, problem has (W + W^T) / 2, which is another
                       problem than the file's */
  int *velocity;    /* global: v_i of the problem is v of the file at velocity[i] */
} nsdae_friction_file;

/* Writes the problem, replacing a file of that name; points and origin may be NULL. Contacts of
 * fewer rows than others get rows of zeros in what FCLIB reads.
 * NSDAE_E_IO: the text says why; NSDAE_E_ARGUMENT and the rest of nsdae_friction_check;
 * NSDAE_E_UNSUPPORTED: built without HDF5. error may be NULL. */
NSDAE_API int nsdae_friction_write(const char *path, const nsdae_friction_problem *problem,
                                   const nsdae_friction_points *points,
                                   const nsdae_friction_origin *origin, nsdae_error *error);

/* Reads a problem; on an error the struct holds nothing. Sizes are looked at before memory is asked
 * for, and are bounded by the file's length. Freedoms are joined to blocks of six (spatial) or
 * three (planar), or where M joins others, to the least blocks that M has. As above; NSDAE_E_IO
 * also where something is missing, of another shape, out of range, not finite, or a problem of
 * rolling friction (dimension 5). */
NSDAE_API int nsdae_friction_read(const char *path, nsdae_friction_file *file, nsdae_error *error);

/* Releases what was read; NULL is allowed. */
NSDAE_API void nsdae_friction_file_release(nsdae_friction_file *file);

#ifdef __cplusplus
}
#endif
#endif
