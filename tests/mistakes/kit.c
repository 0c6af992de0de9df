/* The mistakes of the first table of docs/guide/mistakes.md, with the kit of bodies. */
#include <nsdae/nsdae.h>

#include <math.h>
#include <stdio.h>

enum {
  NO_SUCH_INERTIA = 1,
  INERTIA_OF_THREE,
  PRODUCT_TOO_LARGE,
  MASS_MISSING,
  QUATERNION_OF_THREE,
  QUATERNION_XYZW,
  QUATERNION_IN_PLANE,
  GRAVITY_OF_PLANE,
  DEGREES,
  NO_SUCH_BODY,
  JOINED_TO_ITSELF,
  AXIS_MISSING,
  JOINT_NOT_THERE,
  VELOCITY_OFF,
  RATE_OF_DRIVE,
  SPRING_OF_NO_LENGTH,
  LOAD_NOT_FINITE,
  LIMITS_CROSSED,
  LIMIT_OF_TURN,
  MOTOR_WITHOUT_LIMIT,
  SOLID_OF_SPACE,
  POLYGON_CLOCKWISE,
  TRIANGLE_CLOCKWISE,
  SEGMENT_OF_NO_RADIUS,
  WITHOUT_CORNERS,
  NO_PAIR,
  INERTIA_IN_MM,
  SAME_BODY,
  RESTITUTION_ABOVE_ONE,
  NO_SUCH_MATERIAL,
  TOO_LATE,
  SAME_CENTRE,
  MISTAKES = SAME_CENTRE
};

static int drive(double t, double f[3], void *user)
{
  (void)user;
  f[0] = 0.1 * sin(2 * t);
  f[1] = 0.1 * cos(2 * t); /* 0.2 */
  f[2] = -0.4 * sin(2 * t);
  return 0;
}

static int load(double t, const double x[3], const double u[3], double force[3], double torque[3],
                void *user)
{
  (void)t, (void)x, (void)u, (void)torque, (void)user;
  force[1] = NAN;
  return 0;
}

/* A rod of 1 m that hangs from the origin along x, or two of its kind; each mistake in its place.
 */
static int in_space(int w)
{
  return w == NO_SUCH_INERTIA || w == PRODUCT_TOO_LARGE || w == QUATERNION_OF_THREE ||
         w == QUATERNION_XYZW || w == GRAVITY_OF_PLANE || w == LIMIT_OF_TURN ||
         w == TRIANGLE_CLOCKWISE;
}

static nsdae_rigid_body rod(int w)
{
  nsdae_rigid_body body = {.mass = 1, .inertia = {0, 0, 1}, .position = {0.5}};
  if (in_space(w) || w == INERTIA_OF_THREE) body.inertia[0] = body.inertia[1] = 1;
  if (w == NO_SUCH_INERTIA) body.inertia[2] = 5;
  if (w == PRODUCT_TOO_LARGE) body.product[0] = 2;
  if (w == MASS_MISSING) body.mass = 0;
  if (w == INERTIA_IN_MM) body.inertia[2] = 83333;
  if (w == QUATERNION_IN_PLANE) body.quaternion[0] = 0.8, body.quaternion[3] = 0.6;
  if (w == QUATERNION_XYZW) body.quaternion[3] = 1;
  for (int i = 0; i < 3 && w == QUATERNION_OF_THREE; i++) body.quaternion[i] = 0.1 * (i + 1);
  if (w == DEGREES) body.angle = 90;
  if (w == RATE_OF_DRIVE) body.spin[2] = 0.1, body.velocity[1] = 0.05;
  return body;
}

static void add_solids(nsdae_bodies *b, int w)
{
  const double clockwise[] = {0, 0, 0, 1, 1, 0};
  const double corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const int triangles[] = {0, 1, 2, 0, 3, 2};
  nsdae_solid floor = {.shape = NSDAE_SHAPE_PLANE, .position = {0, -1}};
  nsdae_solid ball = {.shape = NSDAE_SHAPE_DISC, .radius = 0.1};
  if (w == SOLID_OF_SPACE) ball.shape = NSDAE_SHAPE_BOX;
  if (w == POLYGON_CLOCKWISE)
    ball = (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = clockwise};
  if (w == NO_SUCH_MATERIAL) ball.material = 64;
  if (w == TRIANGLE_CLOCKWISE) {
    ball.shape = NSDAE_SHAPE_SPHERE;
    floor = (nsdae_solid){.shape = NSDAE_SHAPE_MESH, .length = {0, 0, 1}};
    floor.points = 4;
    floor.point = corners;
    floor.triangles = 2;
    floor.triangle = triangles;
    nsdae_bodies_set_pair(b, 0, 0, 0.3, 0.5, 0);
  }
  if (w == SEGMENT_OF_NO_RADIUS) ball = (nsdae_solid){.shape = NSDAE_SHAPE_SEGMENT, .length = {1}};
  if (w == WITHOUT_CORNERS) {
    ball.hollow = 1;
    nsdae_bodies_set_pair(b, 0, 0, 0.3, 0.5, 0);
  }
  int ground = nsdae_bodies_add_solid(b, NSDAE_GROUND, &floor);
  int first = nsdae_bodies_add_solid(b, 0, &ball), second = first;
  if (w == SAME_CENTRE) {
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 1}, .position = {0.5}});
    second = nsdae_bodies_add_solid(b, 1, &ball);
  }
  if (w == SAME_BODY) ground = nsdae_bodies_add_solid(b, 0, &ball);
  if (w == SAME_CENTRE) ground = second;
  if (w != NO_PAIR && w != TRIANGLE_CLOCKWISE && w != WITHOUT_CORNERS)
    nsdae_bodies_add_contact(b, ground, first, 0.3, w == RESTITUTION_ABOVE_ONE ? 1.5 : 0.5, 0);
}

static void describe(nsdae_bodies *b, int w)
{
  nsdae_rigid_body body = rod(w);
  nsdae_joint hinge = {.body = {NSDAE_GROUND, 0}, .axis = {0, 0, 1}};
  nsdae_limit limit = {.low = -1, .high = w == LIMITS_CROSSED ? -2 : INFINITY};
  nsdae_bodies_set_gravity(
      b, (const double[]){0, in_space(w) && w != GRAVITY_OF_PLANE ? 0 : -9.81, 0});
  nsdae_bodies_add(b, &body);
  if (w == NO_SUCH_BODY) hinge.body[1] = 1;
  if (w == JOINED_TO_ITSELF) hinge.body[0] = 0;
  if (w == AXIS_MISSING)
    hinge = (nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC, .body = {NSDAE_GROUND, 0}};
  if (w == RATE_OF_DRIVE) hinge.drive = drive;
  if (w < SOLID_OF_SPACE) nsdae_bodies_add_joint(b, &hinge);
  if (w >= SOLID_OF_SPACE) add_solids(b, w);
  if (w == SPRING_OF_NO_LENGTH)
    nsdae_bodies_add_spring(b, &(nsdae_spring){.body = {NSDAE_GROUND, 0}, .stiffness = 1});
  if (w == LOAD_NOT_FINITE) nsdae_bodies_add_load(b, 0, body.position, load, NULL);
  if (w == LIMITS_CROSSED || w == LIMIT_OF_TURN) nsdae_bodies_add_limit(b, &limit);
  if (w == MOTOR_WITHOUT_LIMIT)
    nsdae_bodies_add_motor(b, &(nsdae_motor){.kind = NSDAE_MOTOR_SPEED, .target = 1});
}

static int run(const nsdae_system *system, int w, double *q, double *v, nsdae_error *error)
{
  nsdae_sim *sim;
  int status = nsdae_sim_create(system, NULL, &sim, error);
  if (status < 0) return status;
  if (w == JOINT_NOT_THERE) q[0] += 0.1;
  if (w == VELOCITY_OFF) v[0] = 1;
  status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, 0.1);
  *error = *nsdae_sim_error(sim);
  nsdae_sim_destroy(&sim);
  return status;
}

static void make(int w)
{
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_error error;
  double q[14], v[12];
  nsdae_bodies_create(in_space(w) ? 3 : 2, &b, NULL);
  describe(b, w);
  int status = nsdae_bodies_system(b, &system);
  if (w == TOO_LATE) {
    const nsdae_rigid_body more = rod(w);
    status = nsdae_bodies_add(b, &more);
  }
  error = *nsdae_bodies_error(b);
  if (status == NSDAE_OK) {
    nsdae_bodies_get_start(b, q, v);
    status = run(system, w, q, v, &error);
  }
  printf("%s: %s\n", nsdae_status_name(status), error.text);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  for (int w = 1; w <= MISTAKES; w++) make(w);
}
