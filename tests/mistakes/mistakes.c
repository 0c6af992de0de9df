/* The mistakes of docs/guide/mistakes.md, each made once, in C: what is said to each, line by line.
 * The model is a rod of 1 m and 1 kg on a pivot, q = (x, y, theta), with a stop below; from
 * TANGENT_TWICE on it falls, and its ends touch the floor. */
#include <math.h>
#include <nsdae/nsdae.h>
#include <stdio.h>
#include <string.h>

enum mistake {
  CONTACT_OFF_BY_ONE = 1,
  RESTITUTION_ABOVE_ONE,
  FRICTION_WITHOUT_DIRECTION,
  SLIDE_OF_NO_CONSTRAINT,
  CHANGED_WHILE_IT_RUNS,
  GAP_FORGOTTEN,
  KINEMATICS_FORGOTTEN,
  ONE_TRIANGLE,
  MASS_LEFT_OUT,
  SIGN_OF_NORMAL,
  SIGN_IN_JACOBIAN,
  TERM_OF_OMEGA_LOST,
  INDEX_BEYOND,
  ENTRY_NEVER_SET,
  NORMAL_AS_TANGENT,
  INIT_FORGOTTEN,
  START_IN_THE_STOP,
  DEGREES,
  VELOCITY_OFF,
  DIVISION_BY_ZERO,
  RETURNS_A_COUNT,
  CONSTRAINT_TWICE,
  METHOD_MISSPELT,
  OPTIONS_NOT_SET,
  COEFFICIENTS_FORGOTTEN,
  SIGN_OF_WALL,
  TANGENT_LEFT_OUT,
  TANGENT_TWICE,
  ARM_LEFT_OUT,
  SIGN_OF_ARM,
  MILLIMETRES,
  MISTAKES = MILLIMETRES
};

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const int w = *(const int *)user;
  (void)t, (void)q;
  M[0] = M[ldm + 1] = 1;
  if (w != MASS_LEFT_OUT) M[2 * ldm + 2] = 1.0 / 12;
  if (w == ONE_TRIANGLE) M[2 * ldm] = 0.1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const int w = *(const int *)user;
  (void)q, (void)v;
  F[1] = -9.81;
  if (w == DIVISION_BY_ZERO && t > 0.1) F[2] = 0 / (t - t);
  return w == RETURNS_A_COUNT ? 3 : 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const int w = *(const int *)user;
  (void)t;
  phi[0] = q[0] - sin(q[2]) / 2;
  if (w == CONSTRAINT_TWICE)
    phi[1] = 2 * phi[0];
  else if (w != ENTRY_NEVER_SET)
    phi[1] = q[1] + cos(q[2]) / 2;
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const int w = *(const int *)user;
  (void)t;
  J[0] = 1;
  J[2 * ldj] = -cos(q[2]) / 2;
  J[1] = w == CONSTRAINT_TWICE ? 2 : 0;
  J[ldj + 1] = w == CONSTRAINT_TWICE ? 0 : 1;
  J[2 * ldj + 1] = w == CONSTRAINT_TWICE   ? -cos(q[2])
                   : w == SIGN_IN_JACOBIAN ? sin(q[2]) / 2
                                           : -sin(q[2]) / 2;
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const int w = *(const int *)user;
  (void)t, (void)phi_t;
  omega[0] = sin(q[2]) / 2 * v[2] * v[2];
  omega[1] = w == CONSTRAINT_TWICE ? sin(q[2]) * v[2] * v[2] : cos(q[2]) / -2 * v[2] * v[2];
  if (w == TERM_OF_OMEGA_LOST) omega[1] = 0;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  const int w = *(const int *)user;
  g[w == INDEX_BEYOND] = sin(q[2]) + (w == SIGN_OF_WALL ? 0.1 * t : 0);
  return 0;
}

static int wall(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t, (void)q, (void)w_t, (void)user;
  w_n[0] = -0.1;
  return 0;
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  const int w = *(const int *)user;
  (void)t, (void)ldw;
  W[2] = w == SIGN_OF_NORMAL ? -cos(q[2]) : cos(q[2]);
  return 0;
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const int w = *(const int *)user;
  if (w == NORMAL_AS_TANGENT) return normal(t, q, W, ldw, user);
  if (w != TANGENT_LEFT_OUT) W[0] = 1;
  return 0;
}

/* The lower end and the upper one, above the floor. */
static int ends(double t, const double *q, double *g, void *user)
{
  const double unit = *(const int *)user == MILLIMETRES ? 1000 : 1;
  (void)t;
  g[0] = unit * (q[1] - cos(q[2]) / 2);
  g[1] = unit * (q[1] + cos(q[2]) / 2);
  return 0;
}

static int ends_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const int w = *(const int *)user;
  const double arm = cos(q[2]) / 2, scale = w == TANGENT_TWICE ? 2 : 1;
  (void)t;
  W[0] = scale;
  W[2] = w == ARM_LEFT_OUT ? 0 : scale * arm;
  W[ldw] = scale;
  W[ldw + 2] = w == SIGN_OF_ARM ? arm : -scale * arm;
  return 0;
}

static nsdae_system *describe_falling(int *w)
{
  const nsdae_dims dims = {.nq = 3, .k = 2, .nt = 1};
  nsdae_system *s = NULL;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_user(s, w);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_gap(s, ends);
  nsdae_system_set_gap_tangent(s, ends_tangent);
  for (int i = 0; i < 2; i++) nsdae_system_set_contact(s, i, 0.3, 0.5, 0);
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 0, "x", "m");
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "foot", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 1, "head", "m");
  return s;
}

static nsdae_system *describe(int *w)
{
  nsdae_dims dims = {.nq = 3, .m = 2, .k = 1, .nt = 1};
  nsdae_system *s = NULL;
  if (*w >= TANGENT_TWICE) return describe_falling(w);
  if (*w == FRICTION_WITHOUT_DIRECTION) dims.nt = 0;
  if (*w == SLIDE_OF_NO_CONSTRAINT) dims.f = 1;
  if (*w == KINEMATICS_FORGOTTEN) dims.nv = 2;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_user(s, w);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_constraint_bias(s, bias);
  if (*w != GAP_FORGOTTEN) nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_normal(s, normal);
  if (*w != FRICTION_WITHOUT_DIRECTION) nsdae_system_set_gap_tangent(s, tangent);
  if (*w == SIGN_OF_WALL) nsdae_system_set_contact_bias(s, wall);
  if (*w != COEFFICIENTS_FORGOTTEN)
    nsdae_system_set_contact(s, *w == CONTACT_OFF_BY_ONE, 0.3,
                             *w == RESTITUTION_ABOVE_ONE ? 1.5 : 0.5, 0);
  if (*w == SLIDE_OF_NO_CONSTRAINT) nsdae_system_set_frictional_joint(s, 0, 2, 0.1);
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  nsdae_system_set_name(s, NSDAE_NAME_CONSTRAINT, 1, "pivot_y", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "stop", "m");
  return s;
}

/* What the system is checked for, at a point that is nothing special. */
static int check(nsdae_system *s, int w)
{
  const double q[3] = {0.3, -0.4, 0.7}, v[3] = {0.5, 0.6, -0.8};
  int checked = (w >= SIGN_OF_NORMAL && w <= NORMAL_AS_TANGENT) || w >= TANGENT_TWICE;
  return checked ? nsdae_system_check(s, 0, q, v, 1e-5, NULL) : NSDAE_OK;
}

static int start(nsdae_sim *sim, int w)
{
  const double theta = w == START_IN_THE_STOP ? -0.1 : 0.7, omega = w == VELOCITY_OFF;
  const double q0[3] = {sin(theta) / 2, -cos(theta) / 2, w == DEGREES ? 40 : theta};
  const double v0[3] = {0, 0, omega};
  return w == INIT_FORGOTTEN ? NSDAE_OK : nsdae_sim_init(sim, 0, q0, v0);
}

/* The whole program with that mistake; its first failure is in the record. */
static int run(nsdae_system *s, int w, nsdae_error *error)
{
  nsdae_sim *sim = NULL;
  nsdae_sim_options options = {0};
  if (w != OPTIONS_NOT_SET) nsdae_sim_options_default(&options);
  int status = w == METHOD_MISSPELT ? nsdae_sim_options_set(&options, "method", "implict", error)
                                    : nsdae_sim_create(s, &options, &sim, error);
  if (status < 0) return status;
  if (w == CHANGED_WHILE_IT_RUNS) {
    status = nsdae_system_set_contact(s, 0, 0.6, 0.5, 0);
    *error = *nsdae_system_error(s);
  } else {
    status = start(sim, w);
    if (status >= 0) status = nsdae_sim_run(sim, 0.5);
    *error = *nsdae_sim_error(sim);
  }
  nsdae_sim_destroy(&sim);
  return status;
}

static void make(int w, int checked)
{
  nsdae_error error = {.text = ""};
  nsdae_system *s = describe(&w);
  int status = checked ? check(s, w) : NSDAE_OK;
  if (status < 0)
    error = *nsdae_system_error(s);
  else if (w < ARM_LEFT_OUT)
    status = run(s, w, &error);
  if (w < ARM_LEFT_OUT)
    printf("%s: %s\n", nsdae_status_name(status), error.text);
  else
    printf("doubted: %s\n", strrchr(nsdae_system_unseen(s), ';') + 2); /* the last of them */
  nsdae_system_destroy(&s);
}

int main(void)
{
  for (int w = 1; w <= MISTAKES; w++) make(w, 1);
  for (int w = SIGN_OF_NORMAL; w <= NORMAL_AS_TANGENT; w++) /* without the check */
    make(w, 0);
  return 0;
}
