/* What a system is made of; the writers are in this folder. */
#ifndef NSDAE_SYSTEM_IMPL_H
#define NSDAE_SYSTEM_IMPL_H

#include <stdatomic.h>

#include <nsdae/system.h>

#include "rows.h"
#include "errors.h"
#include "maker.h"
#include "tracked.h"
#include "vector.h"

typedef struct nsdae_coefficients {
  double mu, e_n, e_t;
  int told; /* set by somebody, if only to zero */
} nsdae_coefficients;

/* A position motor of the kit: a row of time stepping with its bound (slides.h); a force of the
 * other methods. */
enum nsdae_position_motor { NSDAE_NO_POSITION, NSDAE_POSITION_ROW, NSDAE_POSITION_FORCE };

/* |F_S| <= bound + mu |lambda| + radius |lambda_first, ...|, lambda of its constraint, and of the
 * constraints of its friction circle. */
typedef struct nsdae_frictional_joint {
  int constraint; /* of mu > 0 */
  double mu, bound;
  int bounded; /* its bound was set, if only to zero */
  int told;
  int first, rows; /* of the friction circle; rows = 0: none */
  double radius;
  enum nsdae_position_motor position; /* in the system of a simulation */
  double kp, kd;
} nsdae_frictional_joint;

enum { NSDAE_NAME_KINDS = NSDAE_NAME_SENSOR + 1 };

typedef struct nsdae_label {
  char name[NSDAE_NAME_SIZE], unit[NSDAE_UNIT_SIZE];
  char rate[NSDAE_UNIT_SIZE + 2]; /* unit/s: what a velocity has that is a coordinate's rate */
} nsdae_label;

/* Of each callback: name, type, what a system must have for it, arguments behind t and q; how many
 * outputs it has, and they (nsdae_output). */
/* clang-format off */
#define NSDAE_CALLBACKS(X) \
  /* callbacks.list: list */ \
  X(mass, nsdae_mass_fn, ANY, (out[0], ld[0]), 1, {{"M", VELOCITY, VELOCITY, 0, 0}}) \
  X(force, nsdae_force_fn, ANY, (at->v, out[0]), 1, {{"F", VELOCITY, -1, 0, 0}}) \
  X(force_damping, nsdae_force_damping_fn, ANY, (at->v, out[0], ld[0]), 1, \
    {{"D", VELOCITY, VELOCITY, 0, 0}}) \
  X(force_stiffness, nsdae_force_stiffness_fn, ANY, (at->v, out[0], ld[0]), 1, \
    {{"K", VELOCITY, VELOCITY, 0, 0}}) \
  X(constraint, nsdae_constraint_fn, CONSTRAINTS, (out[0]), 1, {{"phi", CONSTRAINT, -1, 0, 0}}) \
  X(constraint_jacobian, nsdae_constraint_jacobian_fn, CONSTRAINTS, (out[0], ld[0]), 1, \
    {{"J", CONSTRAINT, VELOCITY, 0, 0}}) \
  X(constraint_bias, nsdae_constraint_bias_fn, CONSTRAINTS, (at->v, out[0], out[1]), 2, \
    {{"phi_t", CONSTRAINT, -1, 0, 0}, {"omega", CONSTRAINT, -1, 0, 0}}) \
  X(gap, nsdae_gap_fn, CONTACTS, (out[0]), 1, {{"g", CONTACT, -1, 0, 0}}) \
  X(gap_normal, nsdae_gap_normal_fn, CONTACTS, (out[0], ld[0]), 1, \
    {{"W", VELOCITY, CONTACT, 0, 0}}) \
  X(gap_tangent, nsdae_gap_tangent_fn, DIRECTIONS, (out[0], ld[0]), 1, \
    {{"W", VELOCITY, CONTACT, 1, 0}}) \
  X(contact_bias, nsdae_contact_bias_fn, CONTACTS, (out[0], out[1]), 2, \
    {{"w_n", CONTACT, -1, 0, 0}, {"w_t", CONTACT, -1, 1, 1}}) \
  X(contact_acceleration, nsdae_contact_acceleration_fn, SLIDING, \
    (at->v, out[0], out[1], out[2]), 3, {{"omega_n", CONTACT, -1, 0, 1}, \
    {"omega_t", CONTACT, -1, 1, 1}, {"omega_s", FRICTIONAL_JOINT, -1, 0, 1}}) \
  X(frictional_joint_tangent, nsdae_frictional_joint_fn, JOINTS, (out[0], ld[0], out[1]), 2, \
    {{"W", VELOCITY, FRICTIONAL_JOINT, 0, 0}, {"w_s", FRICTIONAL_JOINT, -1, 0, 0}}) \
  X(joint_friction_bound, nsdae_joint_friction_bound_fn, JOINTS, (at->v, out[0]), 1, \
    {{"bound", FRICTIONAL_JOINT, -1, 0, 0}}) \
  X(kinematics, nsdae_kinematics_fn, ANY, (at->v, out[0]), 1, {{"qdot", COORDINATE, -1, 0, 0}}) \
  X(potential, nsdae_potential_fn, ANY, (out[0]), 1, {{"energy", -1, -1, 0, 0}}) \
  X(contact_speed, nsdae_contact_speed_fn, ANY, (at->v, out[0]), 1, {{"speed", -1, -1, 0, 0}}) \
  /* callbacks.list: end */
/* clang-format on */

#define FIELD(name, type, ...) type name;

/* Those that are not set are NULL. */
typedef struct nsdae_calls {
  NSDAE_CALLBACKS(FIELD)
  nsdae_mass_blocks_fn mass_blocks;
  nsdae_constraint_rows_fn constraint_rows;
  nsdae_joint_friction_rows_fn joint_friction_rows;
  nsdae_force_blocks_fn force_damping_blocks, force_stiffness_blocks;
  nsdae_contacts_fn contacts;
} nsdae_calls;

#undef FIELD

/* A simulation copies the fields before `owners`; the others change while simulations are created.
 */
struct nsdae_system {
  nsdae_dims dims;
  nsdae_maker maker;
  void *user;
  double epoch; /* t0 of the simulation whose copy this is: see nsdae_system_time */
  nsdae_calls call;
  int by_blocks;                    /* blocks were set: mass_blocks in place of mass */
  int by_list;                      /* the callback contacts in place of numbered contacts */
  nsdae_blocks blocks, coordinates; /* of v and q; one of all where none were set */
  nsdae_coefficients *contact;      /* k */
  nsdae_tracked *tracked;           /* which contacts of a list are the k; NULL: none, or fixed */
  nsdae_frictional_joint *frictional_joint; /* f */
  double *size[NSDAE_NAME_KINDS];           /* lengths, 0 where unknown; NULL: none is known */
  nsdae_label *label[NSDAE_NAME_KINDS];     /* as many as there are of that kind; NULL: no names */
  nsdae_body *body;                         /* bodies: what files show; room for a power of two */
  int bodies;
  nsdae_error error;
  nsdae_error refused; /* of the first setter that was */
  char differences[128], unseen[1400];
  char doubt[320];            /* of the last check */
  atomic_int owners;          /* its handle and its simulations; the last one releases it */
  _Atomic(const char *) late; /* the first setter refused while it had simulations; or NULL */
};

/* NSDAE_OK when every callback that is needed is there, no setter was refused and names are
 * distinct; else NSDAE_E_STATE naming the callback, or what was refused. */
int nsdae_system_complete(const nsdae_system *system, nsdae_error *error);

/* NSDAE_OK where friction that has directions has coefficients, too: they are zero until they are
 * set, which may be a call forgotten. Else NSDAE_E_STATE. */
int nsdae_system_told(const nsdae_system *system, nsdae_error *error);

/* Partitions: of count parts of these sizes, in place of what was there; NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_blocks_make(nsdae_blocks *blocks, int count, const int *size);
void nsdae_blocks_release(nsdae_blocks *blocks);

/* Whether the callbacks fit the blocks: missing is set to one that is not there, or untouched;
 * NSDAE_E_STATE where one is there that does not belong. */
int nsdae_system_check_blocks(const nsdae_system *system, const char **missing, nsdae_error *error);

/* A simulation of the system begins and ends; in between no setter is accepted. Thread-safe. */
void nsdae_system_hold(const nsdae_system *system);
void nsdae_system_let_go(const nsdae_system *system);

/* Every setter ends with one of these. Refused: the error of the system is set to status and the
 * text, and kept for nsdae_sim_create. setter: its name after "nsdae_system_set_", or "add_body".
 */
int nsdae_system_refuse(nsdae_system *system, int status, const char *setter, const char *argument,
                        const char *format, ...) NSDAE_PRINTF(5, 6);
/* Whether the setter may change the system: NSDAE_OK, or NSDAE_E_STATE while it has simulations. */
int nsdae_system_open(nsdae_system *system, const char *setter);

/* How many there are of a kind (enum nsdae_name_kind); 0 of one that is none. */
int nsdae_system_count(const nsdae_system *system, int kind);

/* Contacts that there can be now: k, but of slots those up to the last one that is used. */
static inline int nsdae_system_contacts(const nsdae_system *system)
{
  const nsdae_tracked *tracked = system->tracked;
  return tracked ? nsdae_tracked_count(tracked, system->dims.k) : system->dims.k;
}

/* The n-th contact in the order of sums and eliminations. */
static inline int nsdae_system_contact(const nsdae_system *system, int n)
{
  return system->tracked ? system->tracked->order[n] : n;
}

/* The contacts of the model's list are those in the slots of a table, none at first; and again
 * those of the list. */
void nsdae_system_track(nsdae_system *model, nsdae_tracked *table);
void nsdae_system_track_no_more(nsdae_system *model);

/* 'contact 3', or 'contact 3 "stop"' where it has a name, with the words of the system's maker in
 * brackets; in text, which is returned. Of an island in the numbers of the whole; contacts by their
 * ids. */
enum { NSDAE_CALLED_SIZE = 128 + NSDAE_NAME_SIZE };
const char *nsdae_system_called(const nsdae_system *system, int kind, int i,
                                char text[NSDAE_CALLED_SIZE]);
/* The index of an error: i, of a contact in a slot its id, or -1 where that is no int. */
int nsdae_system_index(const nsdae_system *system, int kind, int i);
/* 'contact of id 7', of a list. */
const char *nsdae_system_called_id(const nsdae_system *system, long id,
                                   char text[NSDAE_CALLED_SIZE]);

/* Contact i of a step: by its number, or of a list by its id there. */
const char *nsdae_system_called_contact(const nsdae_system *system, const long *id, int i,
                                        char text[NSDAE_CALLED_SIZE]);

/* The callbacks that give M and Phi_q. */
static inline const char *nsdae_system_mass_name(const nsdae_system *system)
{
  return system->by_blocks ? "mass_blocks" : "mass";
}

static inline const char *nsdae_system_jacobian_name(const nsdae_system *system)
{
  return system->call.constraint_rows ? "constraint_rows" : "constraint_jacobian";
}

/* The callback that gives the directions of the frictional joints. */
static inline const char *nsdae_system_joint_friction_name(const nsdae_system *system)
{
  return system->call.joint_friction_rows ? "joint_friction_rows" : "frictional_joint_tangent";
}

/* Whether these directions are given, by rows or dense. */
static inline int nsdae_system_has_joint_friction(const nsdae_system *system)
{
  return system->call.joint_friction_rows || system->call.frictional_joint_tangent;
}

/* Whether joint j can have friction in a simulation: its rows are laid out. */
static inline int nsdae_system_joint_rubs(const nsdae_system *system, int j)
{
  const nsdae_frictional_joint *joint = &system->frictional_joint[j];
  if (joint->position) return joint->position == NSDAE_POSITION_ROW;
  return joint->mu > 0 || joint->rows > 0 || joint->bounded || system->call.joint_friction_bound;
}

/* Whether Phi_q is given, by rows or dense. */
static inline int nsdae_system_has_jacobian(const nsdae_system *system)
{
  return system->call.constraint_rows || system->call.constraint_jacobian;
}

/* Whether the derivatives of row i of a kind are formulas of the system's maker. */
int nsdae_system_exact(const nsdae_system *system, int kind, int i);

/* Whether the system's maker knows why the callback that the error names has no value at the point.
 * Then the error names the element and the reason; its status stays. */
int nsdae_system_explain(const nsdae_system *system, double t, const double *q, const double *v,
                         nsdae_error *error);

/* A simulation counts time from its start, so that steps and events keep their digits at any t0.
 * Callbacks, records, errors and files have the time of the user: epoch + t. */
static inline double nsdae_system_time(const nsdae_system *system, double t)
{
  return system->epoch + t;
}

/* Gives the error an index, that of an item, and ends its text with what that is called:
 * ': contact 3 "stop"'. Nothing where error is NULL. */
void nsdae_system_name_item(const nsdae_system *system, int kind, int i, nsdae_error *error);
/* The same of the contact of that id of a list; the index stays. */
void nsdae_system_name_listed(const nsdae_system *system, long id, nsdae_error *error);

/* Ends the error's text with what entry (row, column) of the callback's output [rows x columns]
 * belongs to: ', of contact 3 "stop"'. */
void nsdae_system_name_entry(const nsdae_system *system, const char *callback, int rows, int row,
                             int column, nsdae_error *error);

/* NSDAE_OK, or NSDAE_E_ARGUMENT where two of a kind have one name; NSDAE_E_MEMORY. */
int nsdae_names_distinct(const nsdae_system *system, nsdae_error *error);

/* A callback's return as a status: NSDAE_OK, or NSDAE_E_CALLBACK with its code in the record. */
int nsdae_system_callback_failed(int code, const char *callback, double t, nsdae_error *error);
static inline int nsdae_system_callback_status(int code, const char *callback, double t,
                                               nsdae_error *error)
{
  return code == 0 ? NSDAE_OK : nsdae_system_callback_failed(code, callback, t, error);
}

/* NSDAE_OK, or NSDAE_E_NONFINITE naming the first entry of a [rows x columns] that is none. */
int nsdae_system_not_finite(const nsdae_system *system, const double *a, int rows,
                            const char *callback, double t, nsdae_error *error);
static inline int nsdae_system_finite(const nsdae_system *system, const double *a, int rows,
                                      int columns, const char *callback, double t,
                                      nsdae_error *error)
{
  if (nsdae_all_finite((size_t)rows * (size_t)columns, a)) return NSDAE_OK;
  return nsdae_system_not_finite(system, a, rows, callback, t, error);
}

#endif
