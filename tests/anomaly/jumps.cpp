/* Callbacks that leave by an exception or longjmp: the exception passes, every later call says what
 * happened, and nsdae_sim_destroy frees all of it (an address sanitizer looks for leaks). */
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <nsdae/nsdae.h>

static int failures;
#define EXPECT(condition)                                         \
  do                                                              \
    if (!(condition)) {                                           \
      std::printf("%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      failures++;                                                 \
    }                                                             \
  while (0)

enum way { RETURNS, THROWS, JUMPS };
static way the_way;
static int calls;
static std::jmp_buf back;

static void leave()
{
  if (the_way == RETURNS || ++calls < 3) return;
  if (the_way == JUMPS) std::longjmp(back, 1);
  throw std::runtime_error("thrown by a callback");
}

extern "C" {
static int mass(double, const double *, double *m, int, void *)
{
  m[0] = 1;
  return 0;
}
static int force(double, const double *, const double *, double *f, void *)
{
  leave();
  f[0] = -9.81;
  return 0;
}
static int gap(double, const double *q, double *g, void *)
{
  g[0] = q[0];
  return 0;
}
static int gap_normal(double, const double *, double *w, int, void *)
{
  w[0] = 1;
  return 0;
}
static int observe(const nsdae_record *, nsdae_error *, void *)
{
  leave();
  return 0;
}
static int drive(double t, double f[3], void *)
{
  leave();
  f[0] = 1 + 0.1 * t, f[1] = 0.1, f[2] = 0;
  return 0;
}
}

/* A falling ball, or a driven body of the kit. */
static nsdae_system *model(bool kit)
{
  nsdae_system *system = nullptr;
  if (!kit) {
    nsdae_dims dims = nsdae_dims();
    dims.nq = dims.k = 1;
    nsdae_system_create(&dims, &system, nullptr);
    nsdae_system_set_mass(system, mass);
    nsdae_system_set_force(system, force);
    nsdae_system_set_gap(system, gap);
    nsdae_system_set_gap_normal(system, gap_normal);
    nsdae_system_set_contact(system, 0, 0, 0, 0);
    return system;
  }
  nsdae_bodies *b = nullptr;
  nsdae_rigid_body body = nsdae_rigid_body();
  nsdae_solid plane = nsdae_solid(), ball = nsdae_solid();
  nsdae_joint rod = nsdae_joint();
  body.mass = body.inertia[2] = body.position[1] = 1;
  rod.kind = NSDAE_JOINT_DISTANCE;
  rod.body[0] = NSDAE_GROUND;
  rod.point[1] = 2;
  rod.end[1] = 1;
  rod.drive = drive;
  plane.shape = NSDAE_SHAPE_PLANE;
  ball.shape = NSDAE_SHAPE_DISC;
  ball.radius = 0.1;
  nsdae_bodies_create(2, &b, nullptr);
  nsdae_bodies_add(b, &body);
  nsdae_bodies_add_joint(b, &rod);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane);
  nsdae_bodies_add_solid(b, 0, &ball);
  nsdae_bodies_set_pair(b, 0, 0, 0, 0, 0);
  EXPECT(nsdae_bodies_system(b, &system) == NSDAE_OK);
  nsdae_bodies_destroy(&b);
  return system;
}

/* As a user's own function that frees: below the frame of nsdae_sim_step after an exception. */
static void drop(nsdae_sim **sim)
{
  nsdae_sim_destroy(sim);
}

/* Whether the step was left. */
static bool step(nsdae_sim *sim)
{
  try {
    if (setjmp(back) == 0) {
      nsdae_sim_step(sim);
      return false;
    }
  } catch (const std::runtime_error &e) {
    EXPECT(std::strcmp(e.what(), "thrown by a callback") == 0);
  }
  return true;
}

static void check(way how, int method, bool kit, bool observed)
{
  nsdae_sim_options options;
  nsdae_sim *sim = nullptr;
  nsdae_error error;
  nsdae_record record;
  double q[3] = {1, 1, 0}, v[3] = {0, -0.1, 0};
  nsdae_system *system = model(kit);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.01;
  the_way = RETURNS;
  if (kit) q[0] = 0;
  EXPECT(nsdae_sim_create(system, &options, &sim, &error) == NSDAE_OK);
  if (observed) nsdae_sim_observe(sim, observe, nullptr);
  nsdae_system_destroy(&system);
  EXPECT(nsdae_sim_init(sim, 0, q, v) == NSDAE_OK);
  EXPECT(nsdae_sim_step(sim) >= NSDAE_OK); /* penalty: its law is not e_N */
  the_way = how;
  calls = 0;
  bool left = false;
  for (int i = 0; i < 5 && !left; i++) left = step(sim);
  EXPECT(left);
  the_way = RETURNS;
  if (how == THROWS) {
    EXPECT(nsdae_sim_step(sim) == NSDAE_E_STATE);
    EXPECT(std::strstr(nsdae_sim_error(sim)->text, "left nsdae_sim_step by an exception"));
    EXPECT(std::strstr(nsdae_sim_error(sim)->text, "can only be destroyed"));
    EXPECT(nsdae_sim_init(sim, 0, q, v) == NSDAE_E_STATE);
    EXPECT(nsdae_sim_get_record(sim, &record) == NSDAE_E_STATE);
    drop(&sim);
  } else {
    EXPECT(nsdae_sim_init(sim, 0, q, v) == NSDAE_E_STATE);
    EXPECT(std::strstr(nsdae_sim_error(sim)->text, "longjmp"));
    nsdae_sim_destroy(&sim); /* by the function that ran it */
  }
  EXPECT(sim == nullptr);
  nsdae_sim_destroy(&sim);
}

int main()
{
  const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT,
                         NSDAE_METHOD_PENALTY};
  for (const way how : {THROWS, JUMPS})
    for (const int method : methods)
      for (int form = 0; form < 4; form++) check(how, method, form % 2 == 1, form / 2 == 1);
  std::printf("%d failures\n", failures);
  return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
