/* Random systems, each fixed by its seed: valid (masses positive definite, constraints independent,
 * derivatives right, starts on the constraints and outside what is solid), with every feature at
 * random, and with one call of one callback that can be spoiled.
 *
 *   q_i' = h_i v_i,  M = diag(m_i (1 + a_i sin q_i)),  U = sum g_i q_i + s_i q_i^2 / 2
 *   F_i = -m_i a_i h_i cos(q_i) v_i^2 / 2 - h_i U_i - c_i v_i       so that T + U falls by damping
 *   Phi_j = A_j q + b_j sin(B_j q) - r_j t - Phi_j(0),   g_i the same with rows N_i
 *   W_T, W_S constant, their velocities w constant
 *
 * Every fourth is by blocks, one for each coordinate. */
#ifndef NSDAE_TESTS_RANDOM_SYSTEM_H
#define NSDAE_TESTS_RANDOM_SYSTEM_H

#include <stdint.h>

#include <nsdae/nsdae.h>

#include "random.h"

enum { RANDOM_NQ = 6, RANDOM_M = 3, RANDOM_K = 4, RANDOM_NT = 2 };

enum random_term {
  RANDOM_MASS,
  RANDOM_FORCE,
  RANDOM_CONSTRAINT,
  RANDOM_JACOBIAN,
  RANDOM_BIAS,
  RANDOM_GAP,
  RANDOM_NORMAL,
  RANDOM_TANGENT,
  RANDOM_CONTACT_BIAS,
  RANDOM_ACCELERATION,
  RANDOM_SLIDE,
  RANDOM_KINEMATICS,
  RANDOM_POTENTIAL,
  RANDOM_DAMPING,
  RANDOM_STIFFNESS,
  RANDOM_TERMS
};

/* A function c q + b sin(B q) - r t - offset. */
typedef struct random_row {
  double c[RANDOM_NQ], b, B[RANDOM_NQ], rate, offset;
} random_row;

typedef struct random_fault {
  int term;     /* enum random_term; -1: none */
  long at;      /* the call of it that is spoiled, from 0 */
  int for_ever; /* every call from there on */
  int code;     /* what the callback returns; 0: value is left in an entry instead */
  int entry;    /* modulo how many there are */
  double value;
} random_fault;

typedef struct random_system {
  uint64_t state; /* of the generator */
  nsdae_dims dims;
  unsigned given; /* callbacks that are set, of those that may be left out: 1 << enum random_term */
  int rheonomic;  /* r_j, w not zero: then the constraints do work */
  int turns;      /* matrices depend on q */
  int by_blocks;
  double h[RANDOM_NQ], m[RANDOM_NQ], a[RANDOM_NQ], g[RANDOM_NQ], s[RANDOM_NQ], damp[RANDOM_NQ];
  random_row phi[RANDOM_M], gap[RANDOM_K];
  double W_T[RANDOM_NQ * RANDOM_K * RANDOM_NT], w_T[RANDOM_K * RANDOM_NT];
  double W_S[RANDOM_NQ * RANDOM_M], w_S[RANDOM_M];
  double mu[RANDOM_K], e_n[RANDOM_K], slide_mu[RANDOM_M];
  double q0[RANDOM_NQ], v0[RANDOM_NQ];
  random_fault fault;
  long calls[RANDOM_TERMS], all_calls;
  long calls_max; /* more calls than that fail for good: the run hangs */
} random_system;

enum random_kind { RANDOM_PLAIN, RANDOM_EXTREME };

/* The data of a seed; without a fault. */
void random_system_draw(random_system *r, uint64_t seed, int kind);
/* A fault of that seed, in a term that the system has. */
void random_system_spoil(random_system *r, uint64_t seed);
/* Counts from 0 again, so that the fault comes again. */
void random_system_rewind(random_system *r);
/* The description; r must outlive it. NULL without memory. */
nsdae_system *random_system_make(random_system *r);

#endif
