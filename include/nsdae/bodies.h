/* nsdae: rigid bodies, joints, loads and contacts between shapes, as a system. BSD-3-Clause.
 *
 * A mechanism without a derivation: bodies are placed as they stand at the start, joints, springs
 * and contacts are named by points and axes in space at that moment, and nsdae_bodies_system makes
 * the nsdae_system, with every derivative by formula.
 *
 *   planar    q = [x, y, theta] of each body, v = q'
 *   spatial   q = [x, y, z, q_w, q_x, q_y, q_z], the quaternion turning the body's own axes into
 *             space;  v = [x', y', z', omega_1, omega_2, omega_3], omega in the body's own axes, in
 *             which the inertia is diagonal and M constant
 *
 * named x0, y0, theta0, x1, ... (spatial x0, y0, z0, qw0, qx0, qy0, qz0, ...; vx0, ..., wx0, ...);
 * constraints are named joint0_0, joint0_1, ..., the rows of joint 0.
 *
 * x, y, z is the centre of mass. Lengths are arrays of three, in the plane with z left out (zero).
 * Bodies, solids, joints and contacts are numbered from 0 in the order in which they are added. */
#ifndef NSDAE_BODIES_H
#define NSDAE_BODIES_H

#include <nsdae/shape.h>
#include <nsdae/system.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A mechanism that is being described; opaque. */
typedef struct nsdae_bodies nsdae_bodies;

enum { NSDAE_GROUND = -1 }; /* in place of a body's number */

enum { NSDAE_MATERIALS = 64 }; /* how many materials solids can be of */

/* A rigid body at the start. */
typedef struct nsdae_rigid_body {
  double mass;          /* > 0 [kg] */
  double inertia[3];    /* about the centre of mass and its own axes, > 0 [kg m^2]; in the plane
                           inertia[2] alone */
  double position[3];   /* of the centre of mass [m] */
  double angle;         /* planar: theta [rad] */
  double quaternion[4]; /* spatial: w, x, y, z, brought to unit length; all zero: own axes along
                           those of space */
  double velocity[3];   /* of the centre of mass [m/s] */
  double spin[3];       /* angular velocity in own axes [rad/s]; in the plane spin[2] alone */
} nsdae_rigid_body;

/* A solid: the shape of a body, or a part of it, for contacts and inertia. Its frame is the body's
 * where nothing else is said. Convex, but for a hollow disc.
 *   POINT
 *   DISC      planar: radius; hollow: the solid is outside of the circle
 *   SEGMENT   planar: from (-length[0]/2, 0) to (length[0]/2, 0); radius > 0: rounded to both
 *             sides, 0: solid below (its own y < 0)
 *   POLYGON   planar: its corners, anticlockwise
 *   SPHERE    spatial: radius
 *   CAPSULE   spatial: radius; length[2] between its centres, along its own z
 *   BOX       spatial: edges length[0..2]
 *   PLANE     solid below: y <= 0 in the plane, z <= 0 in space */
typedef struct nsdae_solid {
  int shape;            /* enum nsdae_shape, but for PATH */
  double radius;        /* >= 0 [m] */
  double length[3];     /* [m] */
  int hollow;           /* a disc: not 0 where the hole is meant */
  int points;           /* of a polygon, >= 3 */
  const double *point;  /* points x 2: x, y of each corner; copied */
  double position[3];   /* in the body's frame [m] */
  double angle;         /* planar: against the body's [rad] */
  double quaternion[4]; /* spatial: against the body's; all zero: none */
  int material;         /* 0 .. NSDAE_MATERIALS - 1, for nsdae_bodies_set_pair */
} nsdae_solid;

/* Mass and inertia[3] (own principal axes) about its centre, of a solid of uniform density [kg/m^3;
 * planar kg/m^2] in its own frame; for DISC, POLYGON (whose corners must be given about their
 * centroid), SPHERE, CAPSULE, BOX. NSDAE_E_ARGUMENT names what is wrong. error may be NULL. */
NSDAE_API int nsdae_solid_inertia(const nsdae_solid *solid, double density, double *mass,
                                  double inertia[3], nsdae_error *error);

/* What two bodies keep to each other; see nsdae_joint. */
enum nsdae_joint_kind {
  NSDAE_JOINT_REVOLUTE,    /* common point; spatial: common axis */
  NSDAE_JOINT_PRISMATIC,   /* slides along axis, does not turn */
  NSDAE_JOINT_WELD,        /* nothing moves */
  NSDAE_JOINT_DISTANCE,    /* point (of body 0) and end (of body 1) keep their distance */
  NSDAE_JOINT_SLOT,        /* planar: the point of body 1 stays on a line along axis in body 0; may
                              have friction */
  NSDAE_JOINT_GEAR,        /* planar: theta_1 turns ratio times as far as theta_0 */
  NSDAE_JOINT_SPHERICAL,   /* spatial: common point */
  NSDAE_JOINT_CYLINDRICAL, /* spatial: slides along axis and turns about it */
  NSDAE_JOINT_UNIVERSAL /* spatial: common point; axis of body 0 stays at right angles to cross of
                           body 1 */
};

/* Prescribed motion: drive[0..2] := f(t), f'(t), f''(t). Returns as every callback does. */
typedef int (*nsdae_drive_fn)(double t, double drive[3], void *user);

/* A joint, as it stands at the start; points and axes in space. */
typedef struct nsdae_joint {
  int kind;             /* enum nsdae_joint_kind */
  int body[2];          /* NSDAE_GROUND or a body's number; not the same */
  double point[3];      /* [m] */
  double end[3];        /* DISTANCE: of body 1 [m] */
  double axis[3];       /* PRISMATIC, SLOT, CYLINDRICAL, UNIVERSAL, spatial REVOLUTE: any length */
  double cross[3];      /* UNIVERSAL: at right angles to axis */
  double ratio;         /* GEAR */
  nsdae_drive_fn drive; /* NULL: free. REVOLUTE: the angle of body 1 against body 0 from the start
                           on is f [rad]; PRISMATIC, SLOT (mu = 0), CYLINDRICAL: the way along axis
                           [m]; DISTANCE: the distance [m]; GEAR: theta_1 turns by f further than
                           the gear has it [rad]. The others have no single motion to drive */
  void *user;           /* handed to drive */
  double mu;            /* SLOT: friction, >= 0; else 0 */
} nsdae_joint;

/* A spring and damper between a point of body 0 and one of body 1, in space at the start:
 * F = stiffness (l - rest) + damping l' along the line between them. */
typedef struct nsdae_spring {
  int body[2];               /* NSDAE_GROUND or a body's number; not the same */
  double point[3], end[3];   /* [m] */
  double stiffness, damping; /* >= 0 [N/m, N s/m] */
  double rest;               /* length without force [m], >= 0 */
} nsdae_spring;

/* The same about an axis (in the plane: z); phi is the angle of body 1 against body 0 from the
 * start on. In space the bodies are to be joined so that they turn about this axis alone. */
typedef struct nsdae_torsion {
  int body[2];               /* NSDAE_GROUND or a body's number; not the same */
  double axis[3];            /* spatial: in space, of any length */
  double stiffness, damping; /* >= 0 [N m/rad, N m s/rad] */
  double rest;               /* phi without torque [rad] */
} nsdae_torsion;

/* Force [N] and torque [N m] (in space) on a point of a body, given where it is and how fast [m,
 * m/s]; both come zeroed. Returns as every callback does. */
typedef int (*nsdae_load_fn)(double t, const double position[3], const double velocity[3],
                             double force[3], double torque[3], void *user);

/* What a mechanism has beside its bodies: coordinates, constraints, contacts and frictional joints
 * of one's own, which follow those of the bodies: coordinate 0 of one's own is q[3 bodies], in
 * space q[7 bodies], velocity 0 is v[3 bodies], in space v[6 bodies]. The callbacks are those of
 * nsdae/system.h and get q and v of the whole mechanism. Rows of constraints, contacts and
 * frictional joints are one's own alone, over all velocities; so they may tie bodies and
 * coordinates together (nsdae_bodies_locate says where a point is). M is the block of one's own
 * velocities, dq/dt that of one's own coordinates; F is the whole, with the forces of the bodies in
 * it, to which more are added. mass is needed where nv > 0, constraint where m > 0, gap and
 * gap_tangent where k > 0, frictional_joint_tangent where f > 0, kinematics where nq != nv. A
 * derivative that is missing is filled by differences, as nsdae/system.h says, then of the bodies'
 * rows too. mu, e_N, e_T and names are given to the system: contact 0 of one's own is number dims.k
 * - k there, frictional joint 0 number dims.f - f. */
typedef struct nsdae_user_rows {
  nsdae_dims dims;      /* one's own alone; any may be 0. nt is not read: it is dimension - 1 */
  nsdae_mass_fn mass;   /* M, the block of one's own velocities */
  nsdae_force_fn force; /* added to the F of the bodies */
  nsdae_constraint_fn constraint;                   /* Phi of one's own rows */
  nsdae_constraint_jacobian_fn constraint_jacobian; /* their Phi_q, over all velocities */
  nsdae_constraint_bias_fn constraint_bias;         /* their Phi_t and omega */
  nsdae_gap_fn gap;                                 /* g_N of one's own contacts */
  nsdae_gap_normal_fn gap_normal;                   /* their W_N, over all velocities */
  nsdae_gap_tangent_fn gap_tangent;                 /* their W_T */
  nsdae_contact_bias_fn contact_bias;               /* their w_N and w_T */
  nsdae_contact_acceleration_fn
      contact_acceleration; /* theirs, and that of one's own frictional joints */
  nsdae_frictional_joint_fn
      frictional_joint_tangent;             /* W_S and w_S of one's own frictional joints */
  nsdae_kinematics_fn kinematics;           /* rates of one's own coordinates */
  nsdae_constraint_rows_fn constraint_rows; /* contacts by list: Phi_q in place of
                                               constraint_jacobian; row 0 of one's own is dims.m - m
                                               of the whole, the block the last */
  nsdae_contacts_fn contacts;               /* contacts by list: more of them, with ids below 0 */
  nsdae_potential_fn potential;             /* added to that of the bodies */
  void *user;                               /* handed to each */
} nsdae_user_rows;

/* Makes an empty world of dimension 2 or 3. error may be NULL. NSDAE_E_ARGUMENT, NSDAE_E_MEMORY. */
NSDAE_API int nsdae_bodies_create(int dimension, nsdae_bodies **bodies, nsdae_error *error);
/* Releases it and sets *bodies to NULL. A system made of it must have been destroyed before. */
NSDAE_API void nsdae_bodies_destroy(nsdae_bodies **bodies);

/* Each adds one thing: returns its number, or a status < 0, which is remembered: later calls return
 * it too, and so does nsdae_bodies_system, so that it is enough to look there. NSDAE_E_ARGUMENT
 * (the record names it, its value and its bound), NSDAE_E_STATE (the system has been made),
 * NSDAE_E_MEMORY. */
NSDAE_API int nsdae_bodies_add(nsdae_bodies *bodies, const nsdae_rigid_body *body);
NSDAE_API int nsdae_bodies_add_joint(nsdae_bodies *bodies, const nsdae_joint *joint);
NSDAE_API int nsdae_bodies_add_spring(nsdae_bodies *bodies, const nsdae_spring *spring);
NSDAE_API int nsdae_bodies_add_torsion(nsdae_bodies *bodies, const nsdae_torsion *torsion);
/* A load on the point [3] (in space, at the start) of a body. */
NSDAE_API int nsdae_bodies_add_load(nsdae_bodies *bodies, int body, const double *point,
                                    nsdae_load_fn load, void *user);
/* A solid of a body, or of NSDAE_GROUND. */
NSDAE_API int nsdae_bodies_add_solid(nsdae_bodies *bodies, int body, const nsdae_solid *solid);
/* Lets two solids of different bodies touch; returns the number of the first of its contacts, which
 * follow each other: one for each corner (or centre) of one solid against the other, and in space
 * one for each pair of edges. mu >= 0, e_n and e_t 0 .. 1 as nsdae_system_set_contact. */
NSDAE_API int nsdae_bodies_add_contact(nsdae_bodies *bodies, int solid0, int solid1, double mu,
                                       double e_n, double e_t);

/* Lets every two solids of these materials touch that belong to different bodies; the last call for
 * a pair counts. From then on contacts are by list: those that may be near are found anew in every
 * step, in time that grows with the number of solids where these are of similar size, and a body is
 * a block (nsdae/system.h: large systems), so that there can be many of them. No contact is named
 * then by nsdae_bodies_add_contact, no slot has friction, and the methods are implicit,
 * implicit-printed and moreau. NSDAE_OK or < 0. */
NSDAE_API int nsdae_bodies_set_pair(nsdae_bodies *bodies, int material0, int material1, double mu,
                                    double e_n, double e_t);

/* Gravity [3] [m/s^2]; none at first. */
NSDAE_API int nsdae_bodies_set_gravity(nsdae_bodies *bodies, const double *gravity);

/* Coordinates and rows of one's own beside the bodies, once. NSDAE_E_ARGUMENT: the text names a
 * callback that is missing, or that nothing calls; NSDAE_E_STATE, and as those above. */
NSDAE_API int nsdae_bodies_set_user_rows(nsdae_bodies *bodies, const nsdae_user_rows *own);

/* The system of it all. From now on nothing can be added; bodies must outlive the system, which the
 * caller destroys. The first failure of any call before, NSDAE_E_STATE (no body and no coordinate),
 * NSDAE_E_MEMORY.
 */
NSDAE_API int nsdae_bodies_system(nsdae_bodies *bodies, nsdae_system **system);
/* Sizes, and coordinates q [nq] and velocities v [nv] at the start; those of one's own are 0. */
NSDAE_API int nsdae_bodies_get_dims(const nsdae_bodies *bodies, nsdae_dims *dims);
NSDAE_API int nsdae_bodies_get_start(const nsdae_bodies *bodies, double *q, double *v);
/* Where the point local [3] of a body's own frame is with the coordinates q: point [3]. */
NSDAE_API int nsdae_bodies_locate(const nsdae_bodies *bodies, const double *q, int body,
                                  const double *local, double *point);

/* Why the first call that failed did. */
NSDAE_API const nsdae_error *nsdae_bodies_error(const nsdae_bodies *bodies);

#ifdef __cplusplus
}
#endif
#endif
