/* The equations of a smooth system with continuous contact forces:
 *
 *   z = [q, v, Lambda, I_N, I_T, I_S, E, A]
 *   q' = H v,   [M Phi_q^T; Phi_q 0] [v'; lambda] = [F + W_N F_N + W_T F_T + W_S F_S;
 *                                                    -omega - 2 alpha Phi' - beta^2 Phi]
 *   Lambda' = lambda,  I' = the contact forces,  E' = -(F_N v_N + F_T v_T + F_S v_S)
 *   A' = F v + lambda Phi_t - F_N w_N - F_T w_T - F_S w_S + v^T M' v / 2,
 *   so that v^T M v / 2 should gain A - E; the errors of E and A are not controlled
 *
 * The force of an open contact is zero however deep a trial point is, so that z is smooth up to the
 * time at which the gap is zero. */
#ifndef NSDAE_PENALTY_EQUATIONS_H
#define NSDAE_PENALTY_EQUATIONS_H

#include "newton_kkt.h"
#include "power.h"
#include "stepper.h"
#include "tracking.h"

/* Continuous contact force: the bodies overlap by d and the contact is a spring with damping,
 *
 *   F_N = K d^n (1 + c d' / d'_0),   not below 0,    d'_0: closing velocity at first touch
 *
 *   hertz                  c = 0
 *   hunt-crossley          c = 3 (1 - e) / 2          Hunt and Crossley, J. Appl. Mech. 42, 1975
 *   lankarani-nikravesh    c = 3 (1 - e^2) / 4        Lankarani and Nikravesh, J. Mech. Des. 112,
 * 1990 flores                 c = 8 (1 - e) / (5 e)      Flores et al., Multibody Syst. Dyn. 25,
 * 2011 kelvin-voigt           F_N = K d + b d',  b = 2 zeta sqrt(K m), zeta = -ln e / sqrt(pi^2 +
 * ln^2 e),  m the contact's effective mass
 *
 * and Coulomb's friction regularised over the velocity v_r:  F_T = -mu F_N v_T / sqrt(v_T^2 +
 * v_r^2). */

typedef struct nsdae_penalty_force {
  int kind;                   /* enum nsdae_penalty_law */
  double stiffness, exponent; /* K [N/m^n], n */
} nsdae_penalty_force;

/* slope [2] := dF_N/dd, dF_N/dd' of the same, zero where the force is. */
void nsdae_penalty_slopes(const nsdae_penalty_force *law, double d, double rate, double start_rate,
                          double e, double mass, double *slope);

/* The restitution e' that the law gives where e is asked, with no other force on the contact. The
 * separable laws: m w dw / (1 + c w / v) = -K d^n dd from w = v to -e' v gives
 * c - ln(1 + c) = -c e' - ln(1 - c e'), whatever m, K, n and v are. kelvin-voigt ends at F_N = 0,
 * before d = 0: e' = exp(-2 zeta acos(zeta) / sqrt(1 - zeta^2)), e^-2 for zeta = 1. */
double nsdae_penalty_restitution(const nsdae_penalty_force *law, double e);

/* ---- offsets in z = [q, v, Lambda, I_N, I_T, I_S, E, A] of the equations, and its length; those
 * of the forces in y = [q, v, lambda, F_N, F_T, F_S] are the same. */

typedef struct nsdae_penalty_offsets {
  int lambda, normal, tangential, slide, work, linear, size;
} nsdae_penalty_offsets;

static inline nsdae_penalty_offsets nsdae_penalty_at(const nsdae_dims *d)
{
  int lambda = d->nq + d->nv, normal = lambda + d->m, tangential = normal + d->k;
  int slide = tangential + d->k * d->nt, work = slide + d->f;
  return (nsdae_penalty_offsets){lambda, normal,   tangential,         slide,
                                 work,   work + 2, work + 2 + 3 * d->k};
}

/* ---- where the integrator started last, and the contacts of then: the method's part of
 * the memory. The same start and the same number of steps lead to the same point, bit by bit. */

typedef struct nsdae_penalty_base {
  double *t, *qv;                    /* 1, nq + nv */
  double *first;                     /* 1: length of the first step, or 0 */
  double *since, *start_rate, *mass; /* k: when it closed, d'_0, effective mass */
  double *impulse, *impulse_t;       /* k, k nt: from then to t */
  double *peak;                      /* k: largest force until t */
  int *closed;                       /* k: in contact */
  int *steps, *is_stiff;             /* 1: of the integrator, since t; IDA is at work */
} nsdae_penalty_base;

/* Takes the memory of the method: a base. */
void nsdae_penalty_base_lay(const nsdae_stepper *stepper, nsdae_memory_part *part);
/* Lays the base, and what is kept of tracked contacts, over the memory of a step. */
void nsdae_penalty_base_find(nsdae_penalty_base *base, nsdae_tracking *tracking,
                             const nsdae_stepper *stepper, nsdae_memory *memory);

/* ---- equations */

/* Forces at the last evaluation. */
typedef struct nsdae_penalty_forces {
  double *normal, *tangential, *frictional_joint; /* k, k nt, f */
  double *v_n, *v_t, *v_s;                        /* velocities there */
  double *lambda;                                 /* m */
  double *U, *D; /* nv x f, m x f: a unit friction force on each slide */
} nsdae_penalty_forces;

typedef struct nsdae_penalty_equations {
  nsdae_stepper *stepper;
  nsdae_penalty_force law;
  nsdae_penalty_base base; /* within the memory of the step in work: how its contacts began */
  nsdae_penalty_forces at;
  nsdae_newton_kkt newton; /* see penalty/newton.c */
  int *border_force;       /* of its forces: the place behind lambda in y */
  double *border_room, cj; /* forces; of the factors */
  double *basis;           /* the independent constraints where IDA started, */
  int rank;                /* and their number */
  double *room;            /* nq + nv */
  nsdae_power power;
} nsdae_penalty_equations;

void nsdae_penalty_equations_layout(nsdae_penalty_equations *equations, nsdae_arena *arena);

/* r [nv] += scale times the forces of rows, of contacts with `each` rows. */
void nsdae_penalty_add_forces(const nsdae_terms *terms, const nsdae_rows *rows, int each,
                              double scale, const double *force, double *r);

/* What the integrator asks for (smooth.h); user: the equations. */
int nsdae_penalty_rate(double t, const double *z, double *zdot, int whole, void *user);
int nsdae_penalty_residual(double t, const double *y, const double *ydot, double cj, double *r,
                           void *user);
int nsdae_penalty_setup(double t, const double *y, const double *ydot, double cj, void *user);
int nsdae_penalty_solve(double cj, double *r, double *x, void *user);
int nsdae_penalty_powers(double t, const double *y, const double *ydot, double *rate, void *user);

/* Gaps and contact forces at q, v: see `at` and the terms of the stepper's middle. NSDAE_OK, or
 * what the terms return. */
int nsdae_penalty_evaluate(nsdae_penalty_equations *equations, double t, const double *qv);

/* The forces in `at` := those of y. */
void nsdae_penalty_take(nsdae_penalty_equations *equations, const double *y);

#endif
