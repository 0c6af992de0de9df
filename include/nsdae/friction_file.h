/* nsdae: frictional contact problems in HDF5 files. BSD-3-Clause.
 *
 * The layout is that of FCLIB (Acary, Bremond, Koziara, Perignon, "FCLIB: a collection of discrete
 * 3D frictional contact problems", INRIA RT-444, 2014):
 *
 * - /fclib_local: W, V, R, q, s, mu and a solution
 * - /fclib_global: M, H, G, f, w, b, mu and a solution
 *
 * Additional data, which other readers ignore:
 *
 * - vectors/rows: rows of each contact, if they differ
 * - vectors/compliance: the compliance
 * - blocks: sizes of the blocks of v
 * - /solution/r_low and /solution/l_low: trailing parts of a double-double solution, beside r and l
 *  (bilateral rows)
 * - attributes of the root: time [s], step, method, tol, refine */
#ifndef NSDAE_FRICTION_FILE_H
#define NSDAE_FRICTION_FILE_H

#include <nsdae/friction.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Origin of a problem. */
typedef struct nsdae_friction_origin {
  double time;        /* [s] */
  long step;          /* number of the step, from 1 */
  double tol;         /* tolerance of the residual, > 0 */
  int refine;         /* see nsdae_friction_options */
  const char *method; /* name of the method */
} nsdae_friction_origin;

/* Points written with a problem; each may be NULL. */
typedef struct nsdae_friction_points {
  const double *guess; /* [m] initial guess */
  const double *r;     /* [m] solution */
  const double *u;     /* [m] velocities of the solution */
  const double *low;   /* [m] trailing part of a double-double solution r + low; ignored without
                          r */
} nsdae_friction_points;

/* A problem read from a file. nsdae_friction_file_release frees the arrays. */
typedef struct nsdae_friction_file {
  nsdae_friction_problem problem; /* the problem */
  double *guess;                  /* [m] initial guess; NULL if the file has none */
  double *r;        /* [m] solution; NULL if the file has none. Many files have zeros in its
                       place */
  double *low;      /* [m] trailing part of the solution (nsdae_friction_solve_twice); NULL if
                       the file has none */
  double tol;       /* attribute tol; 0 if missing */
  int refine;       /* attribute refine; 0 if missing */
  double asymmetry; /* asymmetry of W or M in the file: max |W_ij - W_ji| / max |W_ij|, 0 if it
                       is rounding. Otherwise problem has (W + W^T) / 2, a different problem from
                       the file's */
  int *velocity;    /* global: v_i of the problem is v of the file at velocity[i] */
} nsdae_friction_file;

/* Writes a problem and replaces an existing file. points, origin and error may be NULL. Contacts
 * with fewer rows than others are padded with zero rows in FCLIB's data. Errors:
 *
 * - NSDAE_E_IO: the text has the cause
 * - those of nsdae_friction_check
 * - NSDAE_E_UNSUPPORTED: built without HDF5 */
NSDAE_API int nsdae_friction_write(const char *path, const nsdae_friction_problem *problem,
                                   const nsdae_friction_points *points,
                                   const nsdae_friction_origin *origin, nsdae_error *error);

/* Reads a problem; on an error the struct is empty. Sizes are checked against the length of the
 * file before memory is allocated. Velocities are grouped into blocks of six (spatial) or three
 * (planar). If M couples other velocities, the blocks are the smallest that contain the coupling.
 * Errors are those of nsdae_friction_write. NSDAE_E_IO also if data are missing, of the wrong
 * shape, out of range or not finite, and for rolling friction (dimension 5). */
NSDAE_API int nsdae_friction_read(const char *path, nsdae_friction_file *file, nsdae_error *error);

/* Frees what was read; NULL is allowed. */
NSDAE_API void nsdae_friction_file_release(nsdae_friction_file *file);

#ifdef __cplusplus
}
#endif
#endif
