#include "bead.h"

#include <math.h>
#include <stddef.h>

const char *const bead_names[BEAD_TERMS] = {
    "mass", "force",      "constraint",  "constraint_jacobian", "constraint_bias",
    "gap",  "gap_normal", "gap_tangent", "contact_bias",        "potential"};

/* Counts the call and spoils it where that is asked for. */
static int spoil(bead *b, enum bead_term term, double *first)
{
  if (b->calls[term]++ != b->at || b->term != (int)term) return 0;
  if (b->code == 0) *first = b->value;
  return b->code;
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  bead *b = user;
  (void)t;
  M[0] = M[ldm + 1] = 2 * b->mass_scale;
  M[2 * ldm + 2] = 1 + 0.1 * sin(q[2]);
  return spoil(b, BEAD_MASS, M);
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  F[1] = -2 * 9.81;
  F[2] = -q[2] - 0.05 * cos(q[2]) * v[2] * v[2];
  return spoil(user, BEAD_FORCE, F);
}

/* The parabola moves to the right: Phi = y - (x - s t)^2. */
static int constraint(double t, const double *q, double *phi, void *user)
{
  bead *b = user;
  double u = q[0] - b->speed * t;
  phi[0] = q[1] - u * u;
  if (b->repeated) phi[1] = 2 * phi[0];
  return spoil(b, BEAD_CONSTRAINT, phi);
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  bead *b = user;
  double u = q[0] - b->speed * t;
  J[0] = -2 * u;
  J[ldj] = 1;
  for (int j = 0; b->repeated && j < 2; j++) J[j * ldj + 1] = 2 * J[j * ldj];
  return spoil(b, BEAD_JACOBIAN, J);
}

/* Phi_t = 2 u s, omega = -2 (v_x - s)^2. */
static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  bead *b = user;
  double u = q[0] - b->speed * t;
  phi_t[0] = 2 * u * b->speed;
  omega[0] = -2 * (v[0] - b->speed) * (v[0] - b->speed);
  if (b->repeated) {
    phi_t[1] = 2 * phi_t[0];
    omega[1] = 2 * omega[0];
  }
  return spoil(b, BEAD_BIAS, phi_t);
}

/* The floor rises and is wavy: g = y - 0.2 - r t - 0.05 sin x. */
static int gap(double t, const double *q, double *g, void *user)
{
  bead *b = user;
  g[0] = q[1] - 0.2 - b->floor_speed * t - 0.05 * sin(q[0]);
  return spoil(b, BEAD_GAP, g);
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)ldw;
  W[0] = -0.05 * cos(q[0]);
  W[1] = 1;
  return spoil(user, BEAD_NORMAL, W);
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  W[0] = 1;
  W[2] = 0.1;
  return spoil(user, BEAD_TANGENT, W);
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  bead *b = user;
  (void)t;
  (void)q;
  w_n[0] = -b->floor_speed;
  w_t[0] = 0;
  return spoil(b, BEAD_CONTACT_BIAS, w_n);
}

static int potential(double t, const double *q, double *energy, void *user)
{
  (void)t;
  *energy = 2 * 9.81 * q[1] + q[2] * q[2] / 2;
  return spoil(user, BEAD_POTENTIAL, energy);
}

void bead_default(bead *b)
{
  *b = (bead){.speed = 0.3, .floor_speed = 0.05, .term = -1, .mass_scale = 1};
}

nsdae_system *bead_system(bead *b)
{
  const nsdae_dims dims = {.nq = 3, .m = b->repeated ? 2 : 1, .k = 1, .nt = 1};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, b);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_constraint_bias(s, bias);
  nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_normal(s, normal);
  nsdae_system_set_gap_tangent(s, tangent);
  nsdae_system_set_contact_bias(s, contact_bias);
  nsdae_system_set_potential(s, potential);
  nsdae_system_set_contact(s, 0, 0.2, 0.5, 0);
  return s;
}

void bead_start(const bead *b, double q0[3], double v0[3])
{
  q0[0] = 1;
  q0[1] = 1;
  q0[2] = 0.3;
  v0[0] = 0;
  v0[1] = -2 * b->speed; /* y' = 2 u (x' - s) */
  v0[2] = 0;
}
