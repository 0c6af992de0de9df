/* What a system is made of; the only writer is system.c. */
#ifndef NSDAE_SYSTEM_IMPL_H
#define NSDAE_SYSTEM_IMPL_H

#include <nsdae/system.h>

typedef struct nsdae_coefficients {
  double mu, e_n, e_t;
} nsdae_coefficients;

typedef struct nsdae_slide {
  int constraint;
  double mu;
} nsdae_slide;

struct nsdae_system {
  nsdae_dims dims;
  void *user;
  nsdae_mass_fn mass;
  nsdae_force_fn force;
  nsdae_constraint_fn constraint;
  nsdae_constraint_jacobian_fn constraint_jacobian;
  nsdae_constraint_bias_fn constraint_bias;
  nsdae_gap_fn gap;
  nsdae_gap_normal_fn gap_normal;
  nsdae_gap_tangent_fn gap_tangent;
  nsdae_contact_bias_fn contact_bias;
  nsdae_contact_acceleration_fn contact_acceleration;
  nsdae_slide_fn slide_tangent;
  nsdae_kinematics_fn kinematics;
  nsdae_potential_fn potential;
  nsdae_coefficients *contact; /* k */
  nsdae_slide *slide;          /* f */
  nsdae_error error;
  char differences[128];
};

/* NSDAE_OK when every callback that is needed is there, else NSDAE_E_STATE naming it. */
int nsdae_system_complete(const nsdae_system *system, nsdae_error *error);

/* A callback's return as a status: NSDAE_OK, or NSDAE_E_CALLBACK with its code in the record. */
int nsdae_system_callback_status(int code, const char *callback, double t, nsdae_error *error);

/* NSDAE_OK, or NSDAE_E_NONFINITE naming the first entry of a [rows x columns] that is none. */
int nsdae_system_finite(const double *a, int rows, int columns, const char *callback, double t,
                        nsdae_error *error);

#endif
