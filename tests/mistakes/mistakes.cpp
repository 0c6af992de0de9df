/* The mistakes of docs/guide/mistakes.md in C++: see mistakes.c. */
#include <cmath>
#include <cstdio>
#include <nsdae/nsdae.hpp>

namespace
{

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

void set_constraints(nsdae::system &s, int w)
{
  s.constraint([w](double, const double *q, double *phi) {
    phi[0] = q[0] - std::sin(q[2]) / 2;
    if (w == CONSTRAINT_TWICE)
      phi[1] = 2 * phi[0];
    else if (w != ENTRY_NEVER_SET)
      phi[1] = q[1] + std::cos(q[2]) / 2;
  });
  s.constraint_jacobian([w](double, const double *q, double *J, int ldj) {
    J[0] = 1;
    J[2 * ldj] = -std::cos(q[2]) / 2;
    J[1] = w == CONSTRAINT_TWICE ? 2 : 0;
    J[ldj + 1] = w == CONSTRAINT_TWICE ? 0 : 1;
    J[2 * ldj + 1] = w == CONSTRAINT_TWICE   ? -std::cos(q[2])
                     : w == SIGN_IN_JACOBIAN ? std::sin(q[2]) / 2
                                             : -std::sin(q[2]) / 2;
  });
  s.constraint_bias([w](double, const double *q, const double *v, double *, double *omega) {
    omega[0] = std::sin(q[2]) / 2 * v[2] * v[2];
    omega[1] =
        w == CONSTRAINT_TWICE ? std::sin(q[2]) * v[2] * v[2] : std::cos(q[2]) / -2 * v[2] * v[2];
    if (w == TERM_OF_OMEGA_LOST) omega[1] = 0;
  });
}

void set_contact(nsdae::system &s, int w)
{
  auto normal = [w](double, const double *q, double *W, int) {
    W[2] = w == SIGN_OF_NORMAL ? -std::cos(q[2]) : std::cos(q[2]);
  };
  if (w != GAP_FORGOTTEN)
    s.gap([w](double t, const double *q, double *g) {
      g[w == INDEX_BEYOND] = std::sin(q[2]) + (w == SIGN_OF_WALL ? 0.1 * t : 0);
    });
  s.gap_normal(normal);
  if (w == NORMAL_AS_TANGENT)
    s.gap_tangent(normal);
  else if (w != FRICTION_WITHOUT_DIRECTION)
    s.gap_tangent([w](double, const double *, double *W, int) { W[0] = w != TANGENT_LEFT_OUT; });
  if (w == SIGN_OF_WALL)
    s.contact_bias([](double, const double *, double *w_n, double *) { w_n[0] = -0.1; });
  if (w != COEFFICIENTS_FORGOTTEN)
    s.contact(w == CONTACT_OFF_BY_ONE, 0.3, w == RESTITUTION_ABOVE_ONE ? 1.5 : 0.5);
}

void set_ends(nsdae::system &s, int w)
{
  const double unit = w == MILLIMETRES ? 1000 : 1, scale = w == TANGENT_TWICE ? 2 : 1;
  s.gap([unit](double, const double *q, double *g) {
    g[0] = unit * (q[1] - std::cos(q[2]) / 2);
    g[1] = unit * (q[1] + std::cos(q[2]) / 2);
  });
  s.gap_tangent([w, scale](double, const double *q, double *W, int ldw) {
    const double arm = std::cos(q[2]) / 2;
    W[0] = W[ldw] = scale;
    W[2] = w == ARM_LEFT_OUT ? 0 : scale * arm;
    W[ldw + 2] = w == SIGN_OF_ARM ? arm : -scale * arm;
  });
  for (int i = 0; i < 2; i++) s.contact(i, 0.3, 0.5);
  s.name(NSDAE_NAME_COORDINATE, 0, "x", "m");
  s.name(NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  s.name(NSDAE_NAME_CONTACT, 0, "foot", "m");
  s.name(NSDAE_NAME_CONTACT, 1, "head", "m");
}

nsdae::system describe(int w)
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = 3;
  dims.nv = w == KINEMATICS_FORGOTTEN ? 2 : 3;
  dims.m = w < TANGENT_TWICE ? 2 : 0;
  dims.k = w < TANGENT_TWICE ? 1 : 2;
  dims.nt = w != FRICTION_WITHOUT_DIRECTION;
  dims.f = w == SLIDE_OF_NO_CONSTRAINT;
  nsdae::system s(dims);
  s.mass([w](double, const double *, double *M, int ldm) {
    M[0] = M[ldm + 1] = 1;
    if (w != MASS_LEFT_OUT) M[2 * ldm + 2] = 1.0 / 12;
    if (w == ONE_TRIANGLE) M[2 * ldm] = 0.1;
  });
  s.force([w](double t, const double *, const double *, double *F) {
    F[1] = -9.81;
    if (w == DIVISION_BY_ZERO && t > 0.1) F[2] = 0 / (t - t);
    return w == RETURNS_A_COUNT ? 3 : 0;
  });
  if (w >= TANGENT_TWICE) {
    set_ends(s, w);
    return s;
  }
  set_constraints(s, w);
  set_contact(s, w);
  if (w == SLIDE_OF_NO_CONSTRAINT) s.frictional_joint(0, 2, 0.1);
  s.name(NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  s.name(NSDAE_NAME_CONSTRAINT, 1, "pivot_y", "m");
  s.name(NSDAE_NAME_CONTACT, 0, "stop", "m");
  return s;
}

nsdae::sim make_sim(const nsdae::system &s, int w)
{
  if (w != OPTIONS_NOT_SET) {
    nsdae::options options;
    if (w == METHOD_MISSPELT) options.set("method", "implict");
    return nsdae::sim(s, options);
  }
  nsdae_sim_options options = nsdae_sim_options(); /* by hand, in place of nsdae::options */
  nsdae_sim *sim = nullptr;
  nsdae_error record = nsdae_error();
  nsdae_sim_create(s.c(), &options, &sim, &record);
  throw nsdae::error(record);
}

void run(int w, bool checked)
{
  nsdae::system s = describe(w);
  if (checked && ((w >= SIGN_OF_NORMAL && w <= NORMAL_AS_TANGENT) || w >= TANGENT_TWICE))
    s.check(0, {0.3, -0.4, 0.7}, {0.5, 0.6, -0.8});
  if (w >= ARM_LEFT_OUT) {
    const std::string unseen = s.unseen(); /* what is doubted is the last of it */
    std::printf("doubted: %s\n", unseen.substr(unseen.rfind(';') + 2).c_str());
    return;
  }
  nsdae::sim sim = make_sim(s, w);
  if (w == CHANGED_WHILE_IT_RUNS) s.contact(0, 0.6, 0.5);
  const double theta = w == START_IN_THE_STOP ? -0.1 : 0.7;
  if (w != INIT_FORGOTTEN)
    sim.init(0, {std::sin(theta) / 2, -std::cos(theta) / 2, w == DEGREES ? 40 : theta},
             {0, 0, w == VELOCITY_OFF ? 1.0 : 0.0});
  const int status = sim.run(0.5);
  std::printf("%s: %s\n", nsdae_status_name(status), sim.last_error()->text);
}

void make(int w, bool checked)
{
  try {
    run(w, checked);
  } catch (const nsdae::error &error) {
    std::printf("%s: %s\n", nsdae_status_name(error.status()), error.what());
  }
}

} // namespace

int main()
{
  for (int w = 1; w <= MISTAKES; w++) make(w, true);
  for (int w = SIGN_OF_NORMAL; w <= NORMAL_AS_TANGENT; w++) /* without the check */
    make(w, false);
}
