/* nsdae: rigid bodies, joints, forces and contacts between shapes, as a system. BSD-3-Clause.
 *
 * A mechanism is described without equations. Bodies have a pose at the start. Joints, springs and
 * contacts are given by points and axes in space at that time. nsdae_bodies_system makes the
 * nsdae_system; all derivatives are closed formulas.
 *
 *   planar    q = [x, y, theta] of each body, v = q'
 *   spatial   q = [x, y, z, q_w, q_x, q_y, q_z]; the unit quaternion rotates body axes into space
 *             v = [x', y', z', omega_1, omega_2, omega_3]; omega in body axes
 *             the inertia is constant in body axes, and so is M
 *
 * Names:
 *
 * - planar coordinates: x0, y0, theta0, x1, ...
 * - spatial coordinates: x0, y0, z0, qw0, qx0, qy0, qz0, x1, ...
 * - spatial velocities: vx0, vy0, vz0, wx0, wy0, wz0, vx1, ...
 * - constraints: joint0_0, joint0_1, ... for the rows of joint 0; coupler0, coupler1, ...
 *
 * x, y, z is the centre of mass. Vectors are arrays of three; in planar models z is 0. Bodies,
 * solids, joints and contacts are numbered from 0 in the order of the calls that add them. */
#ifndef NSDAE_BODIES_H
#define NSDAE_BODIES_H

#include <nsdae/shape.h>
#include <nsdae/system.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A mechanism under construction; opaque. */
typedef struct nsdae_bodies nsdae_bodies;

enum { NSDAE_GROUND = -1 }; /* the ground, in place of a body's number */

enum { NSDAE_MATERIALS = 64 }; /* number of materials */

/* A rigid body at the start. */
typedef struct nsdae_rigid_body {
  double mass;          /* > 0 [kg] */
  double inertia[3];    /* moments about the centre of mass, > 0 [kg m^2]; planar: inertia[2]
                           only */
  double product[3];    /* spatial: entries (0, 1), (0, 2), (1, 2) of the inertia tensor
                           int r.r 1 - r r^T dm; all zero: body axes are principal axes */
  double position[3];   /* of the centre of mass [m] */
  double angle;         /* planar: theta [rad] */
  double quaternion[4]; /* spatial: w, x, y, z; normalised by the call; all zero: body axes
                           parallel to the axes of space */
  double velocity[3];   /* of the centre of mass [m/s] */
  double spin[3];       /* angular velocity in body axes [rad/s]; planar: spin[2] only */
} nsdae_rigid_body;

/* A solid: the shape of a body or of a part of it, for contacts and inertia. Its frame is the
 * body's frame unless position, angle or quaternion are given. All solids are convex, except a
 * hollow disc, meshes and height fields. A body that is not convex has several solids.
 *
 *   POINT
 *   DISC      planar: radius; hollow: the material is outside the circle. Spatial: radius; across z
 *             of its frame, without thickness
 *   SEGMENT   planar: from (-length[0]/2, 0) to (length[0]/2, 0); radius > 0: rounded on both
 *             sides; radius = 0: material below (y < 0 in its frame)
 *   POLYGON   planar: corners in anticlockwise order
 *   SPHERE    spatial: radius
 *   CAPSULE   spatial: radius; length[2] between the centres of its caps, along z of its frame
 *   BOX       spatial: edge lengths length[0..2]
 *   CYLINDER  spatial: radius; length[2] along z of its frame
 *   CONE      spatial: radius of its base at z = -length[2]/2; apex at z = length[2]/2
 *   ELLIPSOID   spatial: axes (diameters) length[0..2] along those of its frame
 *   PLANE     half-space of material: y <= 0 (planar) or z <= 0 (spatial) in its frame
 *   POLYHEDRON   spatial: the convex hull of points in any order, with at most 1024 corners and a
 *                width of at least 1e-5 of its size. NSDAE_E_UNSUPPORTED: the library was built
 *                without Qhull
 *   MESH      surface of triangles of the ground, anticlockwise seen from outside; beneath it is
 *             material, length[2] > 0 deep. Points in the same place are one. It may be open. A
 *             triangle without area is refused; neighbours of which one is clockwise are a
 *             NSDAE_WARN_MODEL
 *   HEIGHT_FIELD   the same of grid[0] x grid[1] heights z over a rectangle of length[0] x
 *                  length[1] about the origin. A cell is two triangles with a common side from its
 *                  corner of least x and y
 *
 * MESH and HEIGHT_FIELD touch all solids but PLANE and each other by nsdae_bodies_set_pair. A body
 * may have one with exclude = -1, for pictures. Neighbouring triangles in one plane, up to 1.2e-7
 * of the largest coordinate, are one face. Edges within a face and in a valley have no contacts
 *
 * CYLINDER, CONE, ELLIPSOID and DISC (spatial) have exact contacts with PLANE, SPHERE and POINT.
 * With CAPSULE, BOX, POLYHEDRON, MESH, HEIGHT_FIELD and each other they are for time stepping:
 * nsdae_sim_create refuses event and penalty. A DISC and another DISC or a POINT have none: they
 * have no inside. */
typedef struct nsdae_solid {
  int shape;           /* enum nsdae_shape, except PATH */
  double radius;       /* >= 0 [m] */
  double length[3];    /* [m] */
  int hollow;          /* a disc: not 0 for a hole */
  int points;          /* POLYGON: number of corners, >= 3; POLYHEDRON: of points, >= 4; MESH: of
                          points, 3 .. 3 x 2^24 */
  const double *point; /* POLYGON: points x 2, x and y of each corner; POLYHEDRON, MESH: points x 3;
                          HEIGHT_FIELD: grid[1] x grid[0] heights, x runs fastest; copied */
  int triangles;       /* MESH: number of triangles, 1 .. 2^24 */
  const int *triangle; /* MESH: triangles x 3, numbers of points from 0; copied */
  int grid[2];         /* HEIGHT_FIELD: number of heights along x and y, >= 2 */
  double position[3];  /* of its frame in the body's frame [m] */
  double angle;        /* planar: of its frame in the body's frame [rad] */
  double quaternion[4]; /* spatial: of its frame in the body's frame; all zero: no rotation */
  int material;         /* 0 .. NSDAE_MATERIALS - 1, for nsdae_bodies_set_pair */
  int group;            /* bits 0 .. 30 of the groups of the solid; 0: none */
  int exclude;          /* bits of the groups that it does not touch by nsdae_bodies_set_pair; -1:
                           all solids, as of a shape for pictures alone */
} nsdae_solid;

/* Mass and principal moments inertia[3] about the centre of mass, in the frame of the solid.
 * density is uniform and has the unit kg/m^3 (planar kg/m^2). Supported: DISC, POLYGON, SPHERE,
 * CAPSULE, BOX, POLYHEDRON, CYLINDER, ELLIPSOID, closed MESH; of a DISC density is that of its area
 * [kg/m^2]. The points of a POLYGON, POLYHEDRON or MESH must be relative to its centroid, and the
 * axes of its frame principal axes; else, and for a CONE, use nsdae_body_from_solids.
 * NSDAE_E_ARGUMENT: the text names the invalid field. error may be NULL. */
NSDAE_API int nsdae_solid_inertia(const nsdae_solid *solid, double density, double *mass,
                                  double inertia[3], nsdae_error *error);

/* A body of n >= 1 solids of uniform density[n] [kg/m^3, planar kg/m^2]. Sets mass,
 * inertia and product of the body. The frame of the body becomes that of its centre of mass c, with
 * the same axes: position of the body += R c, position of each solid -= c. So the solids stay where
 * they are in space. Before the call position, angle and quaternion of the body place the frame in
 * which the solids are given. Where solids overlap the mass counts for each. All are planar or all
 * are spatial; a DISC is both. Errors as above; index is the number of the solid. */
NSDAE_API int nsdae_body_from_solids(int n, nsdae_solid *solid, const double *density,
                                     nsdae_rigid_body *body, nsdae_error *error);

/* The surface of a POLYHEDRON, MESH or HEIGHT_FIELD in its frame, for pictures: triangles x 3
 * corners x 3 coordinates, anticlockwise seen from outside. triangle has room for 9 (2 points - 4)
 * numbers, of a MESH 9 triangles, of a HEIGHT_FIELD 18 (grid[0] - 1) (grid[1] - 1). Returns the
 * number of triangles, or an error as above. */
NSDAE_API int nsdae_solid_triangles(const nsdae_solid *solid, double *triangle, nsdae_error *error);

/* Reads the triangles of a mesh file as a MESH: Wavefront OBJ (.obj) or STL (.stl, text or binary).
 * scale > 0 multiplies coordinates: metres in a unit of the file (STL names none). Sets shape,
 * points, point, triangles and triangle; the other fields are 0, and length[2] is the caller's. The
 * points also serve a POLYHEDRON, closed surfaces nsdae_body_from_solids. Equal coordinates become
 * one point, and points of no triangle are left out. Of OBJ, v and f are read; the faces must be
 * convex. nsdae_solid_release frees it; after an error it is empty. error may be NULL.
 *
 * - NSDAE_E_IO: the file cannot be read
 * - NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE: the text names file, line or triangle, and the cause
 * - NSDAE_E_MEMORY */
NSDAE_API int nsdae_solid_read(const char *path, double scale, nsdae_solid *solid,
                               nsdae_error *error);
/* Frees point and triangle of nsdae_solid_read and empties the struct; NULL is allowed. */
NSDAE_API void nsdae_solid_release(nsdae_solid *solid);

/* Kinds of joints; see nsdae_joint. */
enum nsdae_joint_kind {
  NSDAE_JOINT_REVOLUTE,    /* common point; spatial: common axis; may have friction */
  NSDAE_JOINT_PRISMATIC,   /* translation along axis, no rotation */
  NSDAE_JOINT_WELD,        /* no relative motion */
  NSDAE_JOINT_DISTANCE,    /* constant distance between point (body 0) and end (body 1) */
  NSDAE_JOINT_SLOT,        /* planar: point of body 1 on a line along axis of body 0; may have
                              friction */
  NSDAE_JOINT_GEAR,        /* planar: rotation of body 1 = ratio x rotation of body 0 */
  NSDAE_JOINT_SPHERICAL,   /* spatial: common point */
  NSDAE_JOINT_CYLINDRICAL, /* spatial: translation along axis and rotation about it */
  NSDAE_JOINT_UNIVERSAL,   /* spatial: common point; axis of body 0 perpendicular to cross of body
                              1 */
  NSDAE_JOINT_SCREW        /* spatial: cylindrical, displacement = pitch x turns about axis */
};

/* Prescribed motion: drive[0..2] := f(t), f'(t), f''(t). Returns the codes of every callback. */
typedef int (*nsdae_drive_fn)(double t, double drive[3], void *user);

/* A joint; points and axes are in space at the start. The coordinates of a joint are the motion of
 * body 1 relative to body 0 since the start:
 *
 *   kind                       coordinate 0                  coordinate 1
 *   REVOLUTE                   rotation [rad]
 *   PRISMATIC                  displacement along axis [m]
 *   SLOT, CYLINDRICAL, SCREW   displacement along axis [m]   rotation [rad]
 *   UNIVERSAL                  rotation about axis [rad]     rotation about cross [rad]
 *
 * The other kinds have none. Turns of a rotation are counted in planar models; in space it is an
 * angle in (-pi, pi].
 *
 * Friction by the load:
 *
 * - SLOT: a force of at most mu |N|, N the normal force (nsdae_system_set_frictional_joint)
 * - REVOLUTE: a torque of at most mu radius |F|, F the force on the pin
 *  (nsdae_system_set_friction_circle)
 *
 * drive prescribes coordinate 0 as f (mu = 0), or:
 *
 * - DISTANCE: the distance [m]
 * - GEAR: angle of body 1 in addition to the gear's [rad] */
typedef struct nsdae_joint {
  int kind;              /* enum nsdae_joint_kind */
  int body[2];           /* NSDAE_GROUND or a body's number; two different ones */
  double point[3];       /* [m] */
  double end[3];         /* DISTANCE: point of body 1 [m] */
  double axis[3];        /* PRISMATIC, SLOT, CYLINDRICAL, UNIVERSAL, SCREW, spatial REVOLUTE: of
                            any length > 0 */
  double cross[3];       /* UNIVERSAL: perpendicular to axis */
  double ratio;          /* GEAR: not 0; SCREW: pitch, displacement per turn, not 0 [m] */
  nsdae_drive_fn drive;  /* NULL: free; other kinds cannot be driven */
  void *user;            /* last argument of drive */
  double mu;             /* SLOT, REVOLUTE: coefficient of friction, >= 0; else 0 */
  double radius;         /* REVOLUTE: of its pin, > 0 if mu > 0; else 0 [m] */
  int collide_connected; /* not 0: its bodies touch by nsdae_bodies_set_pair */
} nsdae_joint;

/* Ends of a coordinate of a joint: contacts without friction, with the gaps coordinate - low and
 * high - coordinate. An infinite end is free. A rotation in space has no count of its turns: it
 * needs both ends, with high - low < 2 pi. There the angle must not go further beyond an end than
 * z = pi - (high - low) / 2: it would come in at the other end. So a step of time stepping needs
 * |omega| dt < z. */
typedef struct nsdae_limit {
  int joint;        /* a joint's number */
  int coordinate;   /* 0 or 1, of nsdae_joint */
  double low, high; /* low < high; -INFINITY or INFINITY: none [m or rad] */
  double e_n;       /* restitution 0 .. 1 */
} nsdae_limit;

/* A rope between a point of body 0 and a point of body 1: a contact without friction, with the gap
 * length - distance. */
typedef struct nsdae_rope {
  int body[2];             /* NSDAE_GROUND or a body's number; two different ones */
  double point[3], end[3]; /* in space at the start [m] */
  double length;           /* > 0 [m] */
  double e_n;              /* restitution 0 .. 1 */
} nsdae_rope;

/* A spring and damper of a coordinate of a joint: force or torque -stiffness (s - rest) - damping
 * s'. SPHERICAL has damping only: torque -damping (omega_1 - omega_0).
 *
 * Turns of a rotation in space are not counted: s - rest is in (-pi, pi] and rest in -pi .. pi.
 * Half a turn from rest the torque changes its sign; the energy is continuous. */
typedef struct nsdae_joint_spring {
  int joint, coordinate;     /* as in nsdae_limit; SPHERICAL: coordinate 0 */
  double stiffness, damping; /* >= 0 */
  double rest;               /* s without force [m or rad]; a rotation in space: -pi .. pi */
} nsdae_joint_spring;

/* Kinds of motors; see nsdae_motor. */
enum nsdae_motor_kind {
  NSDAE_MOTOR_FORCE,   /* force or torque: the target */
  NSDAE_MOTOR_SPEED,   /* s' = target, with the force that this needs */
  NSDAE_MOTOR_POSITION /* force kp (target - s) + kd (target' - s') */
};

/* A motor along a coordinate s of a joint. Its force is at most limit.
 *
 * SPEED is a frictional joint of the system with the bound limit, exact within it. With the target
 * 0 it is dry friction of the joint or a brake. vary gives a bound that changes: a clutch.
 * Frictional joints are numbered from 0 in the order of the calls: joints with mu > 0 and motors
 * SPEED and POSITION.
 *
 * POSITION is implicit in the step of the time-stepping methods: any gains are stable at any dt,
 * and the limit is exact. With event and penalty it is a force, part of F with its derivatives, as
 * FORCE is with all methods. In space a rotation is known up to turns: POSITION takes the way to
 * the target of at most half a turn.
 *
 * Motors are numbered from 0 in the order of the calls: the target of motor i without a drive is
 * control i of a simulation (nsdae_sim_set_control). */
typedef struct nsdae_motor {
  int joint, coordinate;  /* as in nsdae_limit */
  int kind;               /* enum nsdae_motor_kind */
  double target;          /* if drive is NULL, until nsdae_sim_set_control sets another
                             [N, N m; m/s, rad/s; m, rad] */
  double limit;           /* SPEED: >= 0, finite, > 0 with a target; others: > 0, INFINITY: none
                             [N or N m] */
  double kp, kd;          /* POSITION: >= 0, not both 0; else 0 */
  nsdae_drive_fn drive;   /* target and its rates, f, f' and, of POSITION, f''; or NULL */
  nsdae_drive_fn vary;    /* SPEED: the limit f >= 0 at t, in place of limit; or NULL.
                             nsdae_sim_set_friction_bound adds to it */
  void *user, *vary_user; /* last arguments of drive and vary */
} nsdae_motor;

enum { NSDAE_COUPLER_COEFFICIENTS = 6 }; /* of nsdae_coupler */

/* A coupler of coordinates of two joints: s_1 = p[0] + p[1] s_0 + p[2] s_0^2 + ... Two rotations:
 * gears with the ratio p[1]. A displacement s_1 and a rotation s_0: rack and pinion of radius p[1].
 *
 * In space rotations are known up to turns, and so is the coupler:
 *
 * - gears: p[1] must be a fraction n/m, such as the numbers of teeth, with m <= 256
 * - a rotation s_0 with p[2], p[3], ... not 0: it is in (-pi, pi] */
typedef struct nsdae_coupler {
  int joint[2];                         /* numbers of joints */
  int coordinate[2];                    /* of each joint, 0 or 1 */
  double p[NSDAE_COUPLER_COEFFICIENTS]; /* of the polynomial */
} nsdae_coupler;

/* Kinds of sensors; see nsdae_sensor. In the plane vectors have 2 components, moments and rotations
 * 1. */
enum nsdae_sensor_kind {
  NSDAE_SENSOR_COORDINATE,       /* coordinate of joint, turns counted, also in space [m or rad] */
  NSDAE_SENSOR_RATE,             /* its rate [m/s or rad/s] */
  NSDAE_SENSOR_REACTION_FORCE,   /* of the constraints of joint on its body 1 [3] [N] */
  NSDAE_SENSOR_REACTION_MOMENT,  /* the same about point of the joint (DISTANCE: its end), of body 1
                                    [3] [N m] */
  NSDAE_SENSOR_CONTACT_FORCE,    /* of all contacts of solids on body [3] [N] */
  NSDAE_SENSOR_PAIR_FORCE,       /* of solid[0] on solid[1] [3] [N] */
  NSDAE_SENSOR_POSITION,         /* of point of body [3] [m] */
  NSDAE_SENSOR_ORIENTATION,      /* of body: quaternion [4], planar: theta [rad] */
  NSDAE_SENSOR_VELOCITY,         /* of point of body [3] [m/s] */
  NSDAE_SENSOR_ANGULAR_VELOCITY, /* of body, in space [3] [rad/s] */
  NSDAE_SENSOR_ACCELERATION,     /* of point of body [3] [m/s^2] */
  NSDAE_SENSOR_KINETIC_ENERGY,   /* of body [J] */
  NSDAE_SENSOR_POTENTIAL_ENERGY  /* of body, by gravity [J] */
};

/* A sensor: a quantity that is read with nsdae_sim_get_sensor, in the axes of space. One with a
 * name is also the data set /sensor/NAME of trajectory files. A reaction contains the drive of the
 * joint, not its motors, springs, limits and friction. */
typedef struct nsdae_sensor {
  const char *name;      /* copied; NULL or "": none. Without / and control characters, each once */
  int kind;              /* enum nsdae_sensor_kind */
  int body;              /* a body's number */
  int joint, coordinate; /* a joint's number; 0 or 1, of nsdae_joint */
  int solid[2];          /* numbers of solids of different bodies */
  double point[3];       /* of body, in space at the start [m] */
} nsdae_sensor;

/* A spring and damper between a point of body 0 and a point of body 1, in space at the start. The
 * force acts along the line between the points: F = stiffness (l - rest) + damping l'. */
typedef struct nsdae_spring {
  int body[2];               /* NSDAE_GROUND or a body's number; two different ones */
  double point[3], end[3];   /* [m] */
  double stiffness, damping; /* >= 0 [N/m, N s/m] */
  double rest;               /* free length [m], >= 0 */
} nsdae_spring;

/* A rotational spring and damper about an axis (planar: z). phi is the angle of body 1 relative to
 * body 0 since the start. In space the joints must allow relative rotation about this axis only.
 * There turns are not counted: see nsdae_joint_spring. */
typedef struct nsdae_torsion {
  int body[2];               /* NSDAE_GROUND or a body's number; two different ones */
  double axis[3];            /* spatial: in space at the start, of any length > 0;
                                planar: along z, or zero */
  double stiffness, damping; /* >= 0 [N m/rad, N m s/rad] */
  double rest;               /* phi of zero torque [rad]; in space -pi .. pi */
} nsdae_torsion;

/* Force [N] and torque [N m], in space, on a point of a body. Inputs are the point's position [m]
 * and velocity [m/s]. force and torque are zero on entry. Returns the codes of every callback. */
typedef int (*nsdae_load_fn)(double t, const double position[3], const double velocity[3],
                             double force[3], double torque[3], void *user);

/* The user's own coordinates, constraints, contacts and frictional joints ("user rows"). They
 * follow those of the bodies in all arrays.
 *
 * - User coordinate 0 is q[3 bodies] (planar) or q[7 bodies] (spatial).
 * - User velocity 0 is v[3 bodies] (planar) or v[6 bodies] (spatial).
 * - Contact 0 is number dims.k - k of the system; frictional joint 0 is number dims.f - f.
 *
 * The callbacks are those of nsdae/system.h. Their inputs are q and v of the whole mechanism. Their
 * outputs are:
 *
 * - constraints, contacts, frictional joints: the user rows only, over all velocities. A row may
 *  couple bodies and user coordinates; nsdae_bodies_locate gives the position of a point.
 * - mass: the block of the user velocities
 * - kinematics: the rates of the user coordinates
 * - force: F of the whole mechanism; it contains the forces on the bodies, and the callback adds to
 *  it
 *
 * Required callbacks:
 *
 * - mass if nv > 0
 * - constraint if m > 0
 * - gap and gap_tangent if k > 0
 * - frictional_joint_tangent if f > 0
 * - kinematics if nq != nv
 *
 * Missing derivatives are computed by central differences (see nsdae/system.h), then for the rows
 * of the bodies too. mu, e_N, e_T and names are set in the system. */
typedef struct nsdae_user_rows {
  nsdae_dims dims;      /* sizes of the user rows; each may be 0. nt is ignored: it is dimension
                           - 1 */
  nsdae_mass_fn mass;   /* M, the block of the user velocities */
  nsdae_force_fn force; /* adds to F of the bodies */
  nsdae_constraint_fn constraint;                   /* Phi of the user rows */
  nsdae_constraint_jacobian_fn constraint_jacobian; /* their Phi_q, over all velocities */
  nsdae_constraint_bias_fn constraint_bias;         /* their Phi_t and omega */
  nsdae_gap_fn gap;                                 /* g_N of the user contacts */
  nsdae_gap_normal_fn gap_normal;                   /* their W_N, over all velocities */
  nsdae_gap_tangent_fn gap_tangent;                 /* their W_T, over all velocities */
  nsdae_contact_bias_fn contact_bias;               /* their w_N and w_T */
  nsdae_contact_acceleration_fn
      contact_acceleration; /* accelerations of the user contacts and frictional joints */
  nsdae_frictional_joint_fn
      frictional_joint_tangent;             /* W_S and w_S of the user frictional joints */
  nsdae_kinematics_fn kinematics;           /* rates of the user coordinates */
  nsdae_constraint_rows_fn constraint_rows; /* Phi_q by blocks, in place of constraint_jacobian;
                                               user row 0 is row dims.m - m of the system, the
                                               user block is the last */
  nsdae_contacts_fn contacts;               /* additional contacts; their ids are < 0. The system
                                               has a contact list: see nsdae_bodies_set_pair */
  nsdae_potential_fn potential;             /* adds to the potential of the bodies */
  void *user;                               /* last argument of each callback */
} nsdae_user_rows;

/* Creates an empty model of dimension 2 or 3. error may be NULL. NSDAE_E_ARGUMENT, NSDAE_E_MEMORY.
 */
NSDAE_API int nsdae_bodies_create(int dimension, nsdae_bodies **bodies, nsdae_error *error);
/* Sets *bodies to NULL. A system made of the model keeps what it reads: handles can be destroyed in
 * any order, before, during and after a run. */
NSDAE_API void nsdae_bodies_destroy(nsdae_bodies **bodies);

/* Each function adds one object and returns its number, or a status < 0. The first failure is
 * stored: later calls and nsdae_bodies_system return it too. It is enough to check
 * nsdae_bodies_system.
 *
 * - NSDAE_E_ARGUMENT: the record names the argument, its value and its bound
 * - NSDAE_E_STATE: the system has been made
 * - NSDAE_E_MEMORY */
NSDAE_API int nsdae_bodies_add(nsdae_bodies *bodies, const nsdae_rigid_body *body);
NSDAE_API int nsdae_bodies_add_joint(nsdae_bodies *bodies, const nsdae_joint *joint);
/* Adds the contacts of the ends that are given: first low, then high. Limits and ropes are numbered
 * from 0 together, one for each contact; returns the number of the first one. Limit i is the
 * contact K + i behind the contacts 0 .. K - 1 of nsdae_bodies_add_contact. In a contact list its
 * id is L + i: see nsdae_bodies_set_pair. */
NSDAE_API int nsdae_bodies_add_limit(nsdae_bodies *bodies, const nsdae_limit *limit);
NSDAE_API int nsdae_bodies_add_rope(nsdae_bodies *bodies, const nsdae_rope *rope);
NSDAE_API int nsdae_bodies_add_coupler(nsdae_bodies *bodies, const nsdae_coupler *coupler);
NSDAE_API int nsdae_bodies_add_joint_spring(nsdae_bodies *bodies, const nsdae_joint_spring *spring);
NSDAE_API int nsdae_bodies_add_motor(nsdae_bodies *bodies, const nsdae_motor *motor);
NSDAE_API int nsdae_bodies_add_sensor(nsdae_bodies *bodies, const nsdae_sensor *sensor);
NSDAE_API int nsdae_bodies_add_spring(nsdae_bodies *bodies, const nsdae_spring *spring);
NSDAE_API int nsdae_bodies_add_torsion(nsdae_bodies *bodies, const nsdae_torsion *torsion);
/* Adds a force callback on the point [3] of a body, in space at the start. */
NSDAE_API int nsdae_bodies_add_load(nsdae_bodies *bodies, int body, const double *point,
                                    nsdae_load_fn load, void *user);
/* Adds a solid to a body or to NSDAE_GROUND. */
NSDAE_API int nsdae_bodies_add_solid(nsdae_bodies *bodies, int body, const nsdae_solid *solid);
/* Adds the contacts between two solids of different bodies. Returns the number of the first one;
 * the others follow it. Each corner (or centre) of one solid has a contact with the other solid. In
 * space each pair of edges has one, too. mu >= 0; e_n and e_t in 0 .. 1 as in
 * nsdae_system_set_contact. The contacts are fixed, with these numbers. In a system with a contact
 * list (nsdae_bodies_set_pair) they are entries of the list, with these numbers as ids. */
NSDAE_API int nsdae_bodies_add_contact(nsdae_bodies *bodies, int solid0, int solid1, double mu,
                                       double e_n, double e_t);

/* Enables contact between all solids of two materials that belong to different bodies. The last
 * call for a pair of materials applies. Excluded are:
 *
 * - two bodies that a joint connects, unless all of their joints have collide_connected. A body
 *  touches the ground that it is joined to: the ground has all floors and walls
 * - solids of which one is in a group that the other excludes
 *
 * Two solids of nsdae_bodies_add_contact always keep the contacts and coefficients of that call.
 * The system then has a contact list:
 *
 * - A broad phase finds the close pairs in every step. Its time is proportional to the number of
 *  solids if they are of similar size.
 * - Ids follow from the order of the calls and never change. Those of nsdae_bodies_add_contact are
 *  0 .. K - 1. Contact c of the solids i < j has the id K + (i S + j) C + c with S solids. C is
 *  2 corners + edges^2, of the solids with the most corners and edges. A capsule has 1 edge, a box
 *  12, a POLYHEDRON its own, others 0. With a MESH or HEIGHT_FIELD C is at least (1 + corners +
 * edges) P, where P is 4 triangles + points of the largest one. Limit i has the id L + i with L = K
 * + S^2 C.
 *
 * Returns NSDAE_OK or the errors above. */
NSDAE_API int nsdae_bodies_set_pair(nsdae_bodies *bodies, int material0, int material1, double mu,
                                    double e_n, double e_t);

/* What nsdae_bodies_set_name names. */
enum nsdae_named { NSDAE_NAMED_BODY, NSDAE_NAMED_SOLID };

/* Names a body or a solid in messages, pictures and trajectory files. name: 1 to 23 letters, digits
 * and _ - . which no other body or solid has; copied. kind: enum nsdae_named. Returns NSDAE_OK or
 * the errors above. */
NSDAE_API int nsdae_bodies_set_name(nsdae_bodies *bodies, int kind, int i, const char *name);
/* Colour "#rrggbb" of a body or a solid in pictures and trajectory files, once; copied. A solid
 * without one has that of its body. Returns NSDAE_OK or the errors above. */
NSDAE_API int nsdae_bodies_set_colour(nsdae_bodies *bodies, int kind, int i, const char *colour);
/* Number of the material of this name, for nsdae_solid and nsdae_bodies_set_pair; name as above.
 * The first name is number 63, the next one 62, and so on. Returns the number or the errors above.
 */
NSDAE_API int nsdae_bodies_material(nsdae_bodies *bodies, const char *name);

/* Gravity [3] [m/s^2]; default zero. */
NSDAE_API int nsdae_bodies_set_gravity(nsdae_bodies *bodies, const double *gravity);

/* Sets the user rows, once. Errors are those above. NSDAE_E_ARGUMENT: the text names a callback
 * that is missing or never called. NSDAE_E_STATE: also if user rows exist. */
NSDAE_API int nsdae_bodies_set_user_rows(nsdae_bodies *bodies, const nsdae_user_rows *own);

/* Makes the system. Each body is a block of v, the user velocities are the last block
 * (nsdae/system.h: large systems). No object can be added later. The system keeps the model;
 * the caller destroys both, in any order. Returns NSDAE_OK or:
 *
 * - NSDAE_WARN_MODEL: the system is made; nsdae_bodies_error names a likely mistake, such as a
 *  body whose solids touch nothing (docs/guide/mistakes.md)
 * - the first failure of any call before, NSDAE_E_STATE (no body and no coordinate) or
 *  NSDAE_E_MEMORY */
NSDAE_API int nsdae_bodies_system(nsdae_bodies *bodies, nsdae_system **system);
/* Sizes; coordinates q [nq] and velocities v [nv] at the start. The user's own coordinates and
 * velocities are 0. */
NSDAE_API int nsdae_bodies_get_dims(const nsdae_bodies *bodies, nsdae_dims *dims);
NSDAE_API int nsdae_bodies_get_start(const nsdae_bodies *bodies, double *q, double *v);
/* Position point [3] in space of the point local [3] in body axes, at the coordinates q. */
NSDAE_API int nsdae_bodies_locate(const nsdae_bodies *bodies, const double *q, int body,
                                  const double *local, double *point);

/* Bodies in space of one solid each, on a floor and between walls. */
typedef struct nsdae_scene {
  int bodies;             /* >= 0 */
  nsdae_rigid_body *body; /* [bodies] */
  nsdae_solid *solid;     /* [bodies], of each body; nsdae_scene_read gives them the material 1, and
                             has the points of polyhedra behind the last one */
  double wall[2];         /* walls at x and y = wall[0] and wall[1] [m]; wall[0] < wall[1];
                             -INFINITY, INFINITY: none */
  double floor;           /* z of the floor, finite [m] */
  double mu, e_n;         /* of all contacts: friction >= 0, normal restitution 0 .. 1 */
  double g;               /* gravity along -z, >= 0 [m/s^2] */
  double dt;              /* time step for the scene, > 0 [s] */
} nsdae_scene;

/* Reads a scene from a CSV file (docs/guide/scenes.md). nsdae_scene_release frees it; after an
 * error it is empty. error may be NULL.
 *
 * - NSDAE_E_IO: the file cannot be read
 * - NSDAE_E_ARGUMENT: the text names file, line, column, value and bound
 * - NSDAE_E_MEMORY */
NSDAE_API int nsdae_scene_read(const char *path, nsdae_scene *scene, nsdae_error *error);
/* Frees what was read and empties the struct; NULL is allowed. */
NSDAE_API void nsdae_scene_release(nsdae_scene *scene);
/* Adds a scene to a spatial model: gravity, planes of the ground, bodies with their solids. Floor
 * and walls have the material 0. The materials 0 and 1, and 1 and 1, are in contact. The scene is
 * copied. Returns NSDAE_OK or the errors above. */
NSDAE_API int nsdae_bodies_add_scene(nsdae_bodies *bodies, const nsdae_scene *scene);

/* The error record of the first call that failed, or the warning of nsdae_bodies_system. */
NSDAE_API const nsdae_error *nsdae_bodies_error(const nsdae_bodies *bodies);

#ifdef __cplusplus
}
#endif
#endif
