/* What a mechanism is made of: bodies in order, and for each row of constraints, contacts and
 * slides what gives it. Filled by bodies.c, joint.c, shapes.c and forces.c, read by callbacks.c,
 * constraints.c and contacts.c. */
#ifndef NSDAE_BODIES_WORLD_H
#define NSDAE_BODIES_WORLD_H

#include <nsdae/bodies.h>

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include "constraint_primitives.h"
#include "maker.h"
#include "narrow_phase.h"

/* An array that grows: count entries of the same size. */
typedef struct nsdae_list {
  void *at;
  int count, room;
} nsdae_list;

typedef struct nsdae_load {
  int body;
  double point[3]; /* in the body's frame */
  nsdae_load_fn call;
  void *user;
} nsdae_load;

/* Degree of the polynomial of a coupler. */
enum { NSDAE_DEGREE = NSDAE_COUPLER_COEFFICIENTS - 1 };

/* A row of Phi: the coordinate s is held at f(t), or at p(s_0) of the coordinate s_0 of a joint,
 *
 *   Phi = s - f(t),   Phi = s - p(s_0),   up to a multiple of the period if it is above 0 */
typedef struct nsdae_bodies_constraint {
  nsdae_primitive value;
  int joint;                  /* that it is of, or -1 - number of a coupler */
  nsdae_drive_fn drive;       /* f, or NULL: 0 */
  void *user;                 /* its last argument */
  int master;                 /* s_0: NSDAE_COORDINATES x joint + coordinate, or -1: none */
  double p[NSDAE_DEGREE + 1]; /* p(s) = sum_i p_i s^i */
  double period;
} nsdae_bodies_constraint;

/* A joint with its coordinates: number `coordinates` of them are. */
enum { NSDAE_COORDINATES = 2 };
typedef struct nsdae_bodies_joint {
  int kind, body[2], collide_connected, coordinates;
  nsdae_primitive coordinate[NSDAE_COORDINATES];
} nsdae_bodies_joint;

/* An end of a coordinate: the contact sign (s - bound) >= 0 without friction. */
typedef struct nsdae_bodies_limit {
  nsdae_primitive value;
  int joint; /* that it is of, or NSDAE_ROPE */
  double sign, bound, e_n;
} nsdae_bodies_limit;

enum { NSDAE_ROPE = -1 };

/* A slot or a pin with friction, or a motor with v_S = s' - target(t), of a position motor s' -
 * target'(t). */
typedef struct nsdae_bodies_frictional_joint {
  int constraint, joint, motor; /* of the slot, the first of the pin; the motor's number, or -1 */
  int position;                 /* the spring of a position motor, or -1 */
  nsdae_primitive along;
  double mu, bound, circle;   /* circle: mu r of a pin */
  nsdae_drive_fn drive, vary; /* target and bound of a motor, or NULL */
  void *user, *vary_user;
} nsdae_bodies_frictional_joint;

/* Force stiffness (target - s) + damping (target' - s') along a coordinate, within the limit; of a
 * force motor the target, which is 0 of a spring. */
typedef struct nsdae_bodies_spring {
  nsdae_primitive value;
  int owner, number; /* NSDAE_SPRING, ..., and its number among them */
  double stiffness, damping, limit;
  nsdae_drive_fn drive; /* target(t), or NULL: the control of its number */
  void *user;
} nsdae_bodies_spring;

enum { NSDAE_SPRING, NSDAE_TORSION, NSDAE_JOINT_SPRING, NSDAE_FORCE_MOTOR, NSDAE_POSITION_MOTOR };

/* A sensor, its coordinate, its point in the frame of its body. */
typedef struct nsdae_bodies_sensor {
  nsdae_sensor of; /* without its name */
  char name[NSDAE_NAME_SIZE];
  nsdae_primitive value;
  double point[3];
  int angle; /* which of those that are followed; -1: none */
} nsdae_bodies_sensor;

typedef struct nsdae_bodies_pair {
  int material[2];
  double mu, e_n, e_t;
} nsdae_bodies_pair;

/* Name of a body or a solid (enum nsdae_named), or of material NSDAE_MATERIALS - 1 - i; colour of a
 * body or a solid. */
enum { NSDAE_NAMED_MATERIAL = NSDAE_NAMED_SOLID + 1, NSDAE_COLOUR_OF, NSDAE_WORD = 24 };
typedef struct nsdae_bodies_name {
  int kind, i;
  char text[NSDAE_WORD];
} nsdae_bodies_name;

/* What a callback of contacts by list works with, kept from call to call; see broad_phase.h. */
typedef struct nsdae_broad nsdae_broad;
enum { NSDAE_BROADS = 16 };

/* Forces on the bodies, and targets of motors. */
typedef struct nsdae_bodies_forces {
  double gravity[3];
  nsdae_list spring;     /* nsdae_bodies_spring */
  nsdae_list load;       /* nsdae_load */
  nsdae_list target;     /* double, of each motor: the controls at first */
  nsdae_maker_user user; /* of the system */
} nsdae_bodies_forces;

/* The handle of the user and the system made of it read the same object; the last one frees it. */
typedef struct nsdae_bodies_life {
  int made; /* the system was */
  atomic_int owners;
} nsdae_bodies_life;

struct nsdae_bodies {
  int dimension;
  nsdae_bodies_life life;
  nsdae_error error; /* of the first call that failed */
  nsdae_bodies_forces force;
  nsdae_list body;                            /* nsdae_rigid_body */
  nsdae_list constraint;                      /* nsdae_bodies_constraint */
  nsdae_list frictional_joint;                /* nsdae_bodies_frictional_joint */
  nsdae_list solid;                           /* nsdae_solid_of */
  nsdae_list feature;                         /* nsdae_feature: the contacts */
  nsdae_list limit;                           /* nsdae_bodies_limit: contacts behind those */
  nsdae_list pair;                            /* nsdae_bodies_pair */
  _Atomic(nsdae_broad *) broad[NSDAE_BROADS]; /* those that no call uses now */
  nsdae_list joint;                           /* nsdae_bodies_joint */
  nsdae_list name;                            /* nsdae_bodies_name */
  nsdae_list sensor;                          /* nsdae_bodies_sensor */
  nsdae_user_rows own;                        /* beside the bodies; nv filled in */
};

/* From the last argument of a callback. */
static inline nsdae_bodies *nsdae_bodies_of(const void *user)
{
  return (nsdae_bodies *)(uintptr_t)((const nsdae_maker_user *)user)->of;
}

static inline const double *nsdae_control_of(const void *user)
{
  return ((const nsdae_maker_user *)user)->control;
}

/* The i-th entry of a list. */
#define NSDAE_ENTRIES(name, type, list)                                     \
  static inline const type *nsdae_##name##_at(const nsdae_bodies *b, int i) \
  {                                                                         \
    return (const type *)b->list.at + i;                                    \
  }

NSDAE_ENTRIES(body, nsdae_rigid_body, body)
NSDAE_ENTRIES(constraint, nsdae_bodies_constraint, constraint)
NSDAE_ENTRIES(joint, nsdae_bodies_joint, joint)
NSDAE_ENTRIES(limit, nsdae_bodies_limit, limit)
NSDAE_ENTRIES(frictional_joint, nsdae_bodies_frictional_joint, frictional_joint)
NSDAE_ENTRIES(solid, nsdae_solid_of, solid)
NSDAE_ENTRIES(feature, nsdae_feature, feature)
NSDAE_ENTRIES(spring, nsdae_bodies_spring, force.spring)
NSDAE_ENTRIES(sensor, nsdae_bodies_sensor, sensor)

/* Whether the system has a contact list, which then has all contacts; else they are fixed. */
static inline int nsdae_bodies_has_list(const nsdae_bodies *b)
{
  return b->pair.count > 0 || b->own.contacts;
}

/* Fixed contacts: of nsdae_bodies_add_contact, then limits. */
static inline int nsdae_bodies_fixed(const nsdae_bodies *b)
{
  return nsdae_bodies_has_list(b) ? 0 : b->feature.count + b->limit.count;
}

/* Tangential directions: limits have none. */
static inline int nsdae_bodies_nt(const nsdae_bodies *b)
{
  int rough = nsdae_bodies_has_list(b) || b->feature.count + b->own.dims.k > 0;
  return rough ? b->dimension - 1 : 0;
}

/* Coordinates and velocities of a body. */
static inline int nsdae_body_nq(const nsdae_bodies *b)
{
  return b->dimension == 2 ? 3 : 7;
}

static inline int nsdae_body_nv(const nsdae_bodies *b)
{
  return b->dimension == 2 ? 3 : 6;
}

/* Appends an entry of the size, zeroed; NULL where there is no memory, with the record filled. */
void *nsdae_list_add(nsdae_bodies *bodies, nsdae_list *list, size_t size);

/* Whether something may be added: NSDAE_OK, or the first failure, or NSDAE_E_STATE. */
int nsdae_bodies_open(nsdae_bodies *bodies, const void *given, const char *what);
/* The record, the status as return value; keeps the first. index < 0: there is but one. */
int nsdae_bodies_refuse(nsdae_bodies *bodies, int status, const char *what, const char *argument,
                        int index, const char *format, ...);
/* Two bodies that there are, and not the same (ground with ground neither). */
int nsdae_bodies_check_pair(nsdae_bodies *bodies, const char *what, int index, const int *body);
/* Finite numbers; in the plane the third is to be zero where planar_zero says so. */
int nsdae_bodies_check_vector(nsdae_bodies *bodies, const char *what, const char *argument,
                              int index, const double *x, int planar_zero);
/* A finite number of at least least (above it where open). */
int nsdae_bodies_check_least(nsdae_bodies *bodies, const char *what, const char *argument,
                             int index, double x, double least, int open);
/* Finite angle and quaternion. */
int nsdae_bodies_check_turn(nsdae_bodies *bodies, const char *what, int index, double angle,
                            const double *quaternion);

/* A body's pose from all q and v (v NULL: at rest); and at the start. */
nsdae_pose nsdae_bodies_pose(const nsdae_bodies *bodies, int body, const double *q,
                             const double *v);
nsdae_pose nsdae_bodies_start_pose(const nsdae_bodies *bodies, int body);
/* A point and a direction in space at the start, in the body's own frame. */
void nsdae_bodies_own_point(const nsdae_bodies *bodies, int body, const double *x, double *s);
void nsdae_bodies_own_direction(const nsdae_bodies *bodies, int body, const double *x, double *s);

/* The part of a row of velocities that is of body i = 0, 1 with this pose: 3 or 6 numbers. */
void nsdae_bodies_part(const nsdae_bodies *bodies, const nsdae_velocity_row *row, int i,
                       const nsdae_pose *pose, double part[6]);

/* Two bodies and their poses. */
typedef struct nsdae_places {
  int body[2];
  nsdae_pose pose[2];
} nsdae_places;

enum { NSDAE_NO_PLACE = -2 };
static const nsdae_places nsdae_nowhere = {.body = {NSDAE_NO_PLACE, NSDAE_NO_PLACE}};

/* Of these bodies; poses that are there already, of the element before, are kept. */
void nsdae_bodies_place(const nsdae_bodies *bodies, const int body[2], const double *q,
                        const double *v, nsdae_places *places);

/* Adds scale times a row of velocities to the entries of its bodies, stride apart. */
void nsdae_bodies_scatter(const nsdae_bodies *bodies, const nsdae_places *at,
                          const nsdae_velocity_row *row, double scale, double *out, int stride);

/* force[0] at the coordinate s with its rate, and -dF/ds, -dF/ds': force[1], force[2]. 0, or what
 * the drive returned. */
int nsdae_spring_force(const nsdae_bodies_spring *spring, const double *control, double t, double s,
                       double rate, double force[3]);

/* A position motor among frictional joints, with its gains; the errors of all: see maker.h. */
int nsdae_motor_position(const void *bodies, int j, nsdae_gains *gains);
int nsdae_motor_errors(double t, const double *q, double *e, const void *user);

/* Target speed of a frictional joint and its rate; 0, or what the drive returned. */
int nsdae_motor_target(const nsdae_bodies_frictional_joint *joint, const double *control, double t,
                       double target[3]);
/* NULL, or why the target of motor i of bodies is no control. */
const char *nsdae_motor_fixed(const void *bodies, int i);
/* Coefficients and bounds of frictional joints. */
int nsdae_bodies_set_motors(const nsdae_bodies *bodies, nsdae_system *system);

/* Forces of gravity, springs and loads, and of spinning; their energy. */
int nsdae_bodies_force(const void *user, double t, const double *q, const double *v, double *F);
double nsdae_bodies_energy(const nsdae_bodies *bodies, const double *q);

/* Sets their derivatives, by blocks, unless the user has a force too. */
int nsdae_bodies_set_force_derivatives(const nsdae_bodies *bodies, nsdae_system *system);

/* Where a load acts on its body with this pose, and its force and torque; 0 or what it returned. */
int nsdae_load_evaluate(const nsdae_load *load, const nsdae_pose *pose, double t, double x[3],
                        double gave[6]);

/* "revolute" */
const char *nsdae_joint_name(int kind);

/* Coordinate 0 or 1 of a joint; NULL if there is none, with the record filled. any: the rotation
 * of a spherical joint, too, which has rates alone. */
const nsdae_primitive *nsdae_bodies_joint_coordinate(nsdae_bodies *bodies, const char *what,
                                                     int index, int joint, int coordinate, int any);
/* The distance of two points in space at the start. */
nsdae_primitive nsdae_bodies_distance(const nsdae_bodies *bodies, const int body[2],
                                      const double *point, const double *end);

/* Whether the largest principal moment is at most the sum of the others, of five digits. */
static inline int nsdae_is_moment(double largest, double other0, double other1)
{
  return largest <= (other0 + other1) * (1 + 1e-5);
}

/* Name of object i of a kind, or NULL; NSDAE_COLOUR_OF + kind: its colour. */
const char *nsdae_bodies_name_of(const nsdae_bodies *bodies, int kind, int i);

/* L := J omega in body axes. */
static inline void nsdae_body_momentum(const nsdae_rigid_body *body, const double *w, double *L)
{
  const double *J = body->inertia, *P = body->product;
  L[0] = J[0] * w[0] + P[0] * w[1] + P[1] * w[2];
  L[1] = P[0] * w[0] + J[1] * w[1] + P[2] * w[2];
  L[2] = P[1] * w[0] + P[2] * w[1] + J[2] * w[2];
}

/* Likely mistakes of the whole: NSDAE_OK, or NSDAE_WARN_MODEL with the first one in the record. */
int nsdae_bodies_note(nsdae_bodies *bodies);

/* Makes the bodies the maker of the system, which becomes an owner of them: see maker.h. */
void nsdae_bodies_sign(nsdae_bodies *bodies, nsdae_system *system);
/* nsdae_maker.release: gives up an owner. */
void nsdae_bodies_let_go(const void *bodies);

/* Names of sensors; what the maker knows of them. */
int nsdae_bodies_name_sensors(const nsdae_bodies *bodies, nsdae_system *system);
void nsdae_bodies_sense(const nsdae_bodies *bodies, nsdae_maker *maker);

/* The two solids of a contact, and its number among those of the pair. 0: it has none. features:
 * nsdae_broad_features. */
int nsdae_bodies_pair_of(const nsdae_bodies *bodies, long features, long id, int solid[2],
                         long *number);

/* Adds to the system what files of its trajectories show. */
int nsdae_bodies_show(const nsdae_bodies *bodies, nsdae_system *system);

/* A coordinate where it is: the poses of its bodies and its value. */
void nsdae_bodies_coordinate(const nsdae_bodies *bodies, const nsdae_primitive *primitive,
                             const double *q, const double *v, nsdae_places *places,
                             nsdae_primitive_value *value);

/* A limit where it is: gap, omega, and the row of g', in value. A rope without length is slack: its
 * row is zero. */
void nsdae_bodies_limit_value(const nsdae_bodies_limit *limit, const nsdae_pose pose[2],
                              nsdae_primitive_value *value);

/* Sets every callback and coefficient; those of constraints, frictional joints, contacts. */
int nsdae_bodies_set_callbacks(nsdae_bodies *bodies, nsdae_system *system);
int nsdae_bodies_set_constraints(const nsdae_bodies *bodies, nsdae_system *system);
int nsdae_bodies_set_contacts(const nsdae_bodies *bodies, nsdae_system *system);
/* The smallest distance of two parallel planes that enclose the solid; 0 of a point, a line or a
 * mesh, INFINITY of a plane or a hole. */
double nsdae_solid_width(const nsdae_solid_of *solid);
/* nsdae_maker.tunnelling */
int nsdae_bodies_find_tunnelling(const double *q, const double *v, double h, double share,
                                 nsdae_tunnelling *worst, const void *user);
/* nsdae_maker.may_enter */
int nsdae_bodies_may_enter(const double *v, double h, const void *user);
/* nsdae_maker.idle */
int nsdae_bodies_are_idle(const void *of);
/* nsdae_maker.spin */
void nsdae_bodies_spin(const double *v, nsdae_spin *spin, const void *user);
/* Lengths of contacts, or of bodies whose contacts are by list, and of constraints. */
int nsdae_bodies_set_sizes(const nsdae_bodies *bodies, nsdae_system *system);
/* Blocks of bodies, and M. */
int nsdae_bodies_set_blocks(const nsdae_bodies *bodies, nsdae_system *system);
/* In place of fixed contacts. */
int nsdae_bodies_set_contact_list(nsdae_bodies *bodies, nsdae_system *system);

/* Id of limit 0 in a contact list, behind those of all pairs of solids. */
long nsdae_bodies_limit_id(const nsdae_bodies *bodies);
/* NSDAE_E_ARGUMENT: not every id of a contact list is below LONG_MAX. */
int nsdae_bodies_check_ids(nsdae_bodies *bodies);

/* Bodies and the first rows directions of a contact; its omega, from poses with velocities. */
void nsdae_bodies_contact_rows(int dimension, const nsdae_couple *two, const nsdae_still *at,
                               int rows, nsdae_contact *contact);
void nsdae_bodies_contact_omega(int dimension, const nsdae_couple *two, const nsdae_touch *touch,
                                double omega[3]);

/* The features of two solids in order, each handed to add until that returns < 0. Of two
 * that met those that can be within the reach; NULL: all are there. turned: solid 1 is the
 * first of them, as nsdae_meet asks for. */
typedef int (*nsdae_feature_fn)(void *to, const nsdae_feature *feature);
int nsdae_pair_features(const nsdae_solid_of *solids, int solid0, int solid1,
                        const nsdae_meeting *met, nsdae_feature_fn add, void *to);
/* The contacts of these two, in the order of nsdae_pair_is_turned, handed to add until that returns
 * < 0. Gaps up to the reach are there, some others too. */
int nsdae_pair_contacts(const nsdae_solid_of *solids, int solid0, int solid1,
                        const nsdae_couple *two, double reach, nsdae_contact_fn add, void *to);
/* Whether two solids have no contacts: a disc and a point or disc. The error. */
int nsdae_pair_has_none(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1);
/* Whether the pair has no contact at any place: that, or both without corners, or two points. */
int nsdae_pair_is_empty(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1);
int nsdae_bodies_refuse_pair(nsdae_bodies *bodies, const char *what, int index, int solid0,
                             int solid1);
/* NSDAE_OK, or NSDAE_E_ARGUMENT: two solids that may touch have none. */
int nsdae_bodies_check_shapes(nsdae_bodies *bodies);
/* The same: they have contacts for time stepping alone. */
int nsdae_bodies_check_rates(const void *bodies, nsdae_error *error);
int nsdae_pair_is_turned(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1);

#endif
