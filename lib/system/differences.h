/* Derivatives by central differences: for what a user leaves out, and to check what is given.
 *
 * Along the motion dq/dt = H(t,q) v a function f(t,q) has the rate
 *   f' = f_q H v + f_t = ( f(t+s, q+s H v) - f(t-s, q-s H v) ) / 2s + O(s^2)
 * with s ~ eps^(1/3) (error about 1e-10); the second one is of five points, with s ~ eps^(1/6)
 * (about 1e-11). All return a callback's code. */
#ifndef NSDAE_SYSTEM_DIFFERENCES_H
#define NSDAE_SYSTEM_DIFFERENCES_H

#include "arena.h"
#include "lists.h"
#include "system_impl.h"

/* f(t,q) [rows]: the form that constraint and gap share. */
typedef nsdae_constraint_fn nsdae_position_fn;

/* Points of the differences of listed contacts: the centre and two on each side. */
enum { NSDAE_BY_ID_POINTS = 5 };

typedef struct nsdae_differences_of_ids {
  nsdae_contact_list list; /* at a displaced point */
  double *velocity;        /* 5 k (1 + nt): at each point, by slot */
  int *listed;             /* 5 k: whether it is listed there */
  int status;              /* what a list was refused with, NSDAE_ARRAYS_GROW; or NSDAE_OK */
  nsdae_room wanted[2];    /* what the longest list of contacts and of rows took, of those without
                              room, here and in terms, since it was set to zero */
} nsdae_differences_of_ids;

typedef struct nsdae_differences {
  const nsdae_system *system;
  const char *failed;   /* callback that failed where it was not f; else NULL */
  const char *bad;      /* callback of the contacts that first gave what is not finite; else NULL */
  int finer[2];         /* powers of two by which first, second derivatives have shorter steps */
  double *q, *qdot;     /* nq: a displaced point, its rate */
  double *centre;       /* nq: a point on the way to a displaced one */
  double *unit;         /* nv */
  double *plus, *minus; /* max(m, k) */
  double *rate;         /* max(m, k) */
  double *moved;        /* nq: a displaced point of the motion */
  double *W, *velocity; /* nv x max(k, k nt, f); k + k nt + f */
  double *tuned[2];     /* m + k + k nt + f: values of tune, by one step and the next */
  nsdae_differences_of_ids by_id;
} nsdae_differences;

/* system is set before. */
void nsdae_differences_layout(nsdae_differences *differences, nsdae_arena *arena);

/* Room for by_id.list of tracked contacts, to be released; NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_differences_grow(nsdae_differences *differences, const nsdae_room *contacts,
                           nsdae_error *error);

/* D [rows x nv] (or its transpose [nv x rows]): f' = D v + f_t. */
int nsdae_differences_velocity(nsdae_differences *differences, nsdae_position_fn f, int rows,
                               double t, const double *q, double *D, int ldd, int transposed);

/* f' - f_t [rows] along v. */
int nsdae_differences_along(nsdae_differences *differences, nsdae_position_fn f, int rows, double t,
                            const double *q, const double *v, double *along);

/* f_t [rows]. */
int nsdae_differences_time(nsdae_differences *differences, nsdae_position_fn f, int rows, double t,
                           const double *q, double *f_t);

/* omega [rows]: f'' along the motion with v constant. */
int nsdae_differences_second(nsdae_differences *differences, nsdae_position_fn f, int rows,
                             double t, const double *q, const double *v, double *omega);

/* bend [rows]: the same at a fixed t: v^T H v with the second derivatives H of f along velocities.
 */
int nsdae_differences_bend(nsdae_differences *differences, nsdae_position_fn f, int rows, double t,
                           const double *q, const double *v, double *bend);

/* omega_n [k], omega_t [k nt], omega_s [f]: rates of the velocities W^T v + w of contacts and
 * slides along the motion with v constant, by five points (error about 1e-12 where W and w are
 * given); omega_n from the gap where W_N is not. */
int nsdae_differences_contacts(nsdae_differences *differences, double t, const double *q,
                               const double *v, double *omega_n, double *omega_t, double *omega_s);

/* The first two of tracked contacts, from the velocities of their ids; of those that give omega,
 * and of slots that are not listed at (t, q): zero. A contact that is not listed on one side has
 * three points on the other. */
int nsdae_differences_by_id(nsdae_differences *differences, double t, const double *q,
                            const double *v, double *omega_n, double *omega_t);

/* The status of what a function here returned: where it is not 0, that of a list, or of the code of
 * the callback `failed`, or else of `callback`. With the record. */
int nsdae_differences_status(nsdae_differences *differences, int code, const char *callback,
                             double t, nsdae_error *error);

/* NSDAE_OK if a list (0: of contacts, 1: of rows) has room; else NSDAE_ARRAYS_GROW, noted in
 * wanted.
 */
static inline int nsdae_differences_room(nsdae_differences *differences, int list,
                                         const nsdae_room *room, const nsdae_room *taken)
{
  if (nsdae_room_enough(room, taken)) return NSDAE_OK;
  nsdae_room *wanted = &differences->by_id.wanted[list];
  *wanted = nsdae_room_larger(wanted, taken);
  return NSDAE_ARRAYS_GROW;
}

/* Whether velocities or accelerations are of differences. */
int nsdae_differences_used(const nsdae_system *system);

/* Chooses `finer` for the motion at t, q, v. By halves of a step an error of truncation falls to a
 * quarter, or a sixteenth of a second derivative; one of rounding grows by two, or four: the least
 * change is where both are alike. error [2]: that change, of velocities and of accelerations. */
int nsdae_differences_tune(nsdae_differences *differences, double t, const double *q,
                           const double *v, double *error);

/* dq/dt [nq]. */
static inline int nsdae_kinematics(const nsdae_system *system, double t, const double *q,
                                   const double *v, double *qdot)
{
  if (system->call.kinematics) return system->call.kinematics(t, q, v, qdot, system->user);
  int nq = system->dims.nq;
  for (int i = 0; i < nq; i++) qdot[i] = v[i];
  return 0;
}

/* That of nsdae_differences_contacts along the rate qdot. */
double nsdae_differences_acceleration_step(const nsdae_differences *differences, double t,
                                           const double *q);

/* Step along dq/dt that moves each coordinate, and time, by at most scale, or as much more as their
 * rounding asks for far from zero. */
double nsdae_differences_step(int nq, double t, const double *q, const double *qdot, double scale);

#endif
