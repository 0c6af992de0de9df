/* nsdae: time integration of a system. BSD-3-Clause. */
#ifndef NSDAE_SIM_H
#define NSDAE_SIM_H

#include <stddef.h>
#include <nsdae/contact.h>
#include <nsdae/friction.h>
#include <nsdae/lcp.h>
#include <nsdae/params.h>
#include <nsdae/status.h>
#include <nsdae/system.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A simulation; opaque. Only one call at a time may step, start or change it. Any other call during
 * such a call fails with NSDAE_E_STATE and changes nothing, from a callback or from another thread.
 * Exceptions:
 *
 * - Read-only calls may run concurrently: nsdae_sim_get_record, _get_stats, _get_options,
 *  _get_failed_lcp, nsdae_sim_state_size.
 * - Observers may make further calls: see nsdae_observer_fn. */
typedef struct nsdae_sim nsdae_sim;

/* Values of options.method and index of nsdae_method_name. */
enum nsdae_method {
  NSDAE_METHOD_IMPLICIT,
  NSDAE_METHOD_IMPLICIT_PRINTED,
  NSDAE_METHOD_MOREAU,
  NSDAE_METHOD_PENALTY,
  NSDAE_METHOD_EVENT
};

/* Integrators of the smooth phases of penalty and event:
 *
 * - AUTO: DOPRI5; DOP853 if the tolerance makes steps much shorter than dt (event); IDA if
 *   stability limits the step for long.
 * - DOPRI5: explicit pair of Dormand and Prince, orders 5 and 4.
 * - DOP853: explicit pair of Dormand and Prince, order 8, by Hairer.
 * - IDA: backward differences of variable order (SUNDIALS). */
enum nsdae_integrator {
  NSDAE_INTEGRATOR_AUTO,
  NSDAE_INTEGRATOR_DOPRI5,
  NSDAE_INTEGRATOR_DOP853,
  NSDAE_INTEGRATOR_IDA
};

/* Treatment of a rank-deficient Phi_q. */
enum nsdae_redundant { NSDAE_REDUNDANT_ERROR, NSDAE_REDUNDANT_LEAST_NORM };

/* Projection of the end of a step, by time-stepping methods:
 *
 * - NONE: no projection. Time-stepping methods keep the length of coordinates of unit length
 *  (quaternion) in any case. event and penalty normalise them when it has doubled or halved.
 * - CONSTRAINTS: onto the constraints. Coordinates of unit length keep their length.
 * - CONTACTS: also onto g_N = 0 of contacts that were closed in the step and overlap.
 * - DEPTHS: as CONSTRAINTS; a contact that overlapped at the start of the step and remained closed
 *  keeps its depth at most. On curved surfaces its depth otherwise grows by
 *  (1 - e_N) h^2 v^2 / (2 r) in every step.
 * - SLOP (implicit and moreau): closed contacts that are deeper than a slop are moved to it. The
 *  change is the least in the metric of M; then the constraints are projected.
 *  The slop is h^2 a / 2, with the largest acceleration a that the forces can give to the contact,
 *  with and without the constraints. It does not depend on the axes if there are blocks
 *  (nsdae_system_set_blocks; nsdae_bodies has one a body).
 *  Constraints are also projected if one has drifted by more than 1e-4 of its size
 *  (nsdae_system_set_size).
 *  Velocities stay, except along the constraints. projection_energy of the record is the potential
 *  energy that this adds.
 * - AUTO (default): SLOP for implicit and moreau, else NONE.
 *
 * Velocities are projected onto the constraints, and the multipliers have that impulse, except
 * with frictional joints whose friction depends on multipliers.
 *
 * penalty and event accept NONE only: event satisfies both conditions in another way, and overlap
 * is part of the contact law of penalty. */
enum nsdae_projection {
  NSDAE_PROJECTION_NONE,
  NSDAE_PROJECTION_CONSTRAINTS,
  NSDAE_PROJECTION_CONTACTS,
  NSDAE_PROJECTION_DEPTHS,
  NSDAE_PROJECTION_SLOP,
  NSDAE_PROJECTION_AUTO
};

/* Initialise with nsdae_sim_options_default; an uninitialised struct is an error. */
typedef struct nsdae_sim_options {
  int method;                             /* enum nsdae_method */
  double dt;                              /* time step [s] */
  double baumgarte_alpha, baumgarte_beta; /* Baumgarte stabilisation in smooth phases [1/s] */
  double iteration_tol;                   /* relative change of q, v that ends an iteration */
  int iteration_max;                      /* maximum number of iterations per step */
  int redundant;                          /* enum nsdae_redundant */
  double rank_tol;                        /* sine of the angle to the other rows below which a
                                             constraint is redundant */
  double contact_tol;  /* tolerance of the scaled natural residual of contact problems; 0 ("auto",
                          the default): 1e-10, and 1e-4 for islands of more than 11 contacts and
                          frictional joints with second-order cones. contact_tol of the record is
                          the tolerance that was used */
  double contact_work; /* multiplications by J that the contact problem of an island may take: a
                          tenth of it to reach contact_tol, all to reach the bound of contact_give.
                          An island of fewer than 100 contacts counts as one of 100. 0 (default):
                          1e4 to a tolerance of 1e-5 or more; else 1e6, and a tenth of it is at
                          most the budget of nsdae_friction_options */
  double contact_give; /* a step goes on with the best point if its residual is at most this times
                          contact_tol, or times 1e-4 if that is more; 1: it fails above
                          contact_tol */
  int polygon; /* edges of the friction polygon for nt = 2: 3 .. 32; 0: second-order Coulomb cone */
  double impact_velocity;   /* a slower closing velocity is no impact [m/s] */
  double rtol, atol;        /* tolerances of the integrator of penalty and event */
  int penalty_law;          /* enum nsdae_penalty_law */
  double penalty_stiffness; /* K [N/m^n] */
  double penalty_exponent;  /* n */
  double friction_velocity; /* regularisation velocity of friction in penalty [m/s] */
  int integrator;           /* enum nsdae_integrator, of penalty and event */
  double step_max;          /* largest step of the integrator of penalty and event [s]; infinite:
                               dt is the only bound */
  double accumulation_time; /* event closes an accumulation of impacts if its remaining time is
                               shorter [s] */
  int events_max;           /* events in one dt for method event; beyond it, implicit takes the
                               step */
  int projection;           /* enum nsdae_projection */
  double start_tol;         /* relative error of the initial conditions */
  int inner_steps_max;      /* internal steps of penalty and event in one dt */
  int start_check;          /* 1: nsdae_sim_init checks callbacks for gross errors */
  int contacts_max;         /* maximum number of contacts in a contact list */
  int threads;              /* threads of a step with a block-sparse Jacobian, for contact detection
                               and islands: 1 .. 256 */
  unsigned initialised;     /* set by nsdae_sim_options_default */
} nsdae_sim_options;

/* Sets every option to its default. */
NSDAE_API void nsdae_sim_options_default(nsdae_sim_options *options);
/* Sets one option from text, e.g. ("dt", "0.005") or ("method", "moreau"). NSDAE_E_OPTION: no such
 * key or choice (the text suggests the nearest); NSDAE_E_ARGUMENT: out of range. */
NSDAE_API int nsdae_sim_options_set(nsdae_sim_options *options, const char *key, const char *value,
                                    nsdae_error *error);
/* The table of the options: keys, units, ranges, defaults. */
NSDAE_API const nsdae_params *nsdae_sim_options_table(void);

/* Name of a method and its one-line description; NULL past the last. */
NSDAE_API const char *nsdae_method_name(int method);
NSDAE_API const char *nsdae_method_summary(int method);

/* An impact of one contact: at one time (event-driven) or in one step (time stepping). */
typedef struct nsdae_impact {
  double time;                  /* event: time of the impact; penalty: time of first contact,
                                   possibly in an earlier step; time stepping: end of the step
                                   [s] */
  int contact;                  /* index into the record's contacts, from 0 */
  double normal_impulse;        /* [N s]; time stepping: includes the contact force of the step */
  double tangential_impulse[2]; /* [N s], the first nt entries */
  double velocity_before, velocity_after; /* normal velocity of the contact [m/s] */
  double peak_force; /* largest normal force of a continuous contact [N]; 0 for a rigid contact */
  int accumulation;  /* 1: an accumulation of infinitely many impacts (Zeno) that ends at rest at
                        time */
  long id;           /* of the contact; fixed contacts: its number */
  int block[2];      /* blocks of a listed contact, -1: the ground; fixed contacts: -1, -1 */
} nsdae_impact;

/* A mode transition of a contact or frictional joint; method event only. */
typedef struct nsdae_change {
  double time;          /* [s] */
  int contact;          /* index into the record's contacts, from 0; -1: a frictional joint */
  int frictional_joint; /* from 0; -1: a contact */
  int mode_before, mode_after; /* enum nsdae_mode */
  long id;                     /* as in nsdae_impact; -1: a frictional joint */
  int block[2];                /* as in nsdae_impact */
} nsdae_change;

/* Contacts of a step.
 *
 * - fixed contacts: all of them, open or closed, in their order; id is the number, from 0
 * - contact list: those that were closed in the step, in the order of the callback; none at the
 *   start. Of event and penalty those that were closed, had an impulse or a change of mode, or
 *   overlap at the end, in the order in which they came near */
typedef struct nsdae_contact_set {
  int count;                        /* fixed contacts: k */
  const long *id;                   /* [count] */
  const int *block;                 /* [2 count] blocks of a listed contact, -1: the ground; fixed
                                       contacts: -1, -1 */
  const double *gap;                /* [count] fixed contacts: at the end of the step; contact list:
                                       at the last evaluation. This is the end of the step, with
                                       moreau its middle unless projection moves contacts. */
  const double *normal_impulse;     /* [count] over the step */
  const double *tangential_impulse; /* [count nt] */
  const int *mode;                  /* [count] enum nsdae_mode */
} nsdae_contact_set;

/* Violation of the laws by a step. Each value has the contact or constraint of its maximum: from 0
 * (contact list: index into the record's contacts), -1 if the value is 0. The energies satisfy
 *
 *   energy = energy_start + work - dissipated + unexplained */
typedef struct nsdae_certificate {
  double pull;             /* max(0, -Lambda_N): adhesive impulse [N s] */
  double cone_excess;      /* max(0, |Lambda_T| - mu Lambda_N): friction outside the cone [N s];
                              time stepping: also of frictional joints, beyond their limit, then
                              cone_contact is -1 */
  double penetration;      /* max(0, -g_N) [m] */
  double constraint_drift; /* max |Phi| [in its units] */
  double constraint_rate;  /* max |dPhi/dt|; moreau: at the middle of the step, with v of its end */
  double complementarity;  /* max |Lambda_N xi_N| [J]; time stepping: xi_N = v_N(+) + e_N v_N(-);
                              event: xi_N = v_N of closed contacts; penalty: 0 */
  double energy;           /* kinetic + potential, after the step [J] */
  double work;             /* work since the start of forces without potential, moving constraints
                              and moving contacts [J] */
  double dissipated;       /* work absorbed by contact and friction impulses since the start [J] */
  double unexplained;      /* numerical energy since the start [J]: < 0: loss, > 0: gain */
  int pull_contact, cone_contact, penetration_contact; /* contact of that value, or -1 */
  int drift_constraint, rate_constraint;               /* constraint of that value, or -1 */
  int complementarity_contact;                         /* contact of that value, or -1 */
} nsdae_certificate;

/* The state after a step (step = 0: at the start) and its certificate. All pointers belong to the
 * simulation and are valid until the next step. */
typedef struct nsdae_record {
  long step;                        /* from 0 (the start) */
  double time;                      /* [s] */
  double duration;                  /* length of the step [s]; 0: the start, or a state that was
                                       set */
  const double *q, *v;              /* [nq], [nv] */
  const double *acceleration;       /* [nv] mean over the step, including impacts; 0 at the start */
  const double *multiplier;         /* [m] mean constraint force over the step */
  const double *gap;                /* [k], as the next ones: fixed contacts; contact list: NULL */
  const double *normal_impulse;     /* [k] over the step */
  const double *tangential_impulse; /* [k nt] */
  const double *normal_force;       /* [k] mean over the step [N], including impacts */
  const double *tangential_force;   /* [k nt] */
  const int *mode;                  /* [k] enum nsdae_mode */
  const double *frictional_joint_impulse; /* [f] friction impulse of the frictional joints over
                                             the step */
  const double *frictional_joint_force;   /* [f] mean friction force */
  const int *frictional_joint_mode; /* [f] NSDAE_MODE_SLIP or NSDAE_MODE_STICK; NSDAE_MODE_OPEN:
                                       frictionless */
  nsdae_contact_set contacts;       /* contacts of the step, fixed or listed */
  double kinetic, potential;        /* [J]; potential is 0 without its callback */
  double dissipated;                /* work absorbed by all contact impulses since the start [J] */
  double projection_energy;   /* part of dissipated, < 0 there: potential energy that projection =
                                 slop added since the start [J] */
  double lcp_residual;        /* scaled natural residual of the contact problem, 0 without one;
                                 time stepping: that of friction.h over all contacts of the step;
                                 event: the largest of its complementarity problems */
  double contact_tol;         /* the largest tolerance of these problems, 0 without one: the option,
                                 or what auto chose */
  double constraint_drift;    /* max |Phi| */
  double penetration;         /* max(0, -g_N) of all contacts */
  const nsdae_impact *impact; /* [impacts] */
  int impacts;                /* number of impacts in the step */
  const nsdae_change *change; /* [changes] */
  int changes;                /* number of mode transitions in the step */
  nsdae_certificate certificate; /* violation of the laws by the step */
} nsdae_record;

/* Observer: called once with every record.
 *
 * - 0: continue
 * - > 0: stop after the record (NSDAE_STOPPED)
 * - < 0: the run fails with this status; the state is the one before the step
 *
 * A step becomes the state after all observers have returned >= 0. After a failure, the next step
 * or run first calls the observer that failed. Observers that have seen the record are not called
 * again, unless the repeated step differs (other end time, options or a new state). Then the same
 * step number is reported again and replaces the earlier record.
 *
 * An observer may set *error, which is cleared before the call. It may read the simulation and add
 * or remove observers, including itself. Calls that step or change the simulation return
 * NSDAE_E_STATE. */
typedef int (*nsdae_observer_fn)(const nsdae_record *record, nsdae_error *error, void *user);

enum { NSDAE_OBSERVERS_MAX = 8 };

/* Interrupt function; a value other than 0 ends the current step. */
typedef int (*nsdae_interrupt_fn)(void *user);

/* Statistics since nsdae_sim_init. */
typedef struct nsdae_stats {
  long steps, smooth_steps, contact_steps;      /* all, without and with a closed contact */
  long lcps, lcp_pivots, iterations;            /* iterations: of the implicit methods */
  long mass_evals, force_evals, jacobian_evals; /* calls of the callbacks */
  long impacts;                                 /* as recorded */
  long events, accumulations;                   /* method event: events; closed accumulations */
  long fallback_steps;                          /* method event: dt taken by implicit instead */
  long inexact_steps; /* steps with an island whose residual is above its tolerance, see
                         contact_give */
  long frozen_steps;  /* implicit: steps whose contacts were frozen, as their iteration stagnated */
  long accumulations_early; /* method event: accumulations closed before accumulation_time,
                               because the velocity is below rtol and atol or chattering lasted
                               thousands of impacts */
  double rank_retained;  /* of retained rows of Phi_q: smallest sine of the angle to the others; 1
                            if none */
  double rank_discarded; /* of discarded (redundant) rows: the largest; 0 if none */
  int rank, rank_most;   /* smallest and largest rank of Phi_q; if they differ, see rank_tol */
  double worst_residual; /* of all contact problems */
  double contact_tol;    /* the largest tolerance of them; 0: there was none */
  double worst_drift;    /* max |Phi| [in its units] */
  double worst_penetration; /* max(0, -g_N) [m] */
  double energy_start;      /* kinetic + potential at the start [J] */
  double energy_balance;    /* energy + dissipated - energy_start [J]; includes the work of forces
                               without potential */
  int warnings;         /* sum of 1: energy, 2: penetration, 4: drift, 8: Painleve, 16: impacts, 32:
                           restitution, 64: contact, 128: singular; see NSDAE_WARN_ENERGY */
  double wall_time;     /* time in nsdae_sim_run and nsdae_sim_step [s] */
  int contact_capacity; /* capacity of the contact list; it grows between steps */
  int contact_growths;  /* number of growths */
  int islands;          /* islands of the last step */
  int island_contacts;  /* contacts of the largest island */
  nsdae_certificate certificate; /* maxima over all records; energies of the last record */
} nsdae_stats;

/* Creates a simulation and allocates its memory. The system must be complete and cannot be changed
 * while it has simulations. options are copied; NULL: defaults. error may be NULL.
 *
 * - NSDAE_E_ARGUMENT
 * - NSDAE_E_STATE: a required callback is missing
 * - NSDAE_E_MEMORY
 * - the first error of a setter of the system (see nsdae_system_clear_error) */
NSDAE_API int nsdae_sim_create(const nsdae_system *system, const nsdae_sim_options *options,
                               nsdae_sim **sim, nsdae_error *error);
/* Frees the simulation and sets *sim to NULL; NULL and a pointer to NULL are allowed. While another
 * call on the simulation is in progress, nothing is freed and *sim is unchanged.
 *
 * A callback must return. After one that left by a C++ exception or longjmp, only this call is
 * accepted; every other one is NSDAE_E_STATE. After longjmp it must be in the function that ran the
 * simulation, or in a caller of that function. */
NSDAE_API void nsdae_sim_destroy(nsdae_sim **sim);

/* Makes initial conditions consistent, by the least change in the metric of M. q0 [nq] is moved
 * onto the constraints and to g_N >= 0; coordinates of unit length (quaternions) are normalised. v0
 * [nv] is then moved onto the velocity constraints. The simulation is not started and its state is
 * unchanged. On an error q0 and v0 are unchanged:
 *
 * - NSDAE_E_CONVERGENCE: no consistent state nearby; the text names the row
 * - NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE, NSDAE_E_CALLBACK, NSDAE_E_MASS, NSDAE_E_MEMORY */
NSDAE_API int nsdae_sim_project(nsdae_sim *sim, double t0, double *q0, double *v0);

/* Starts at t0 with q0 [nq], v0 [nv]; evaluates every term once. May be called again to restart.
 * Observers receive the start as step 0, in the first step or run. The run counts time from t0, so
 * that its steps do not depend on t0.
 *
 * Initial conditions must satisfy the constraints, their rates, unit lengths and, with event, 0 <=
 * g_N. The tolerance start_tol (default 1e-6, for six digits; 1e300 accepts any) is relative to the
 * terms:
 *
 *   |Phi_i|, -g_N,i      <= start_tol (1 + |row|_1 max |q|)            row of Phi_q, column of W_N
 *   |Phi_q v + Phi_t|_i  <= start_tol (1 + |row|_1 max |v| + |Phi_t,i|)
 *
 * An overlap within the tolerance is removed by event, by the least change in the metric of M. Time
 * stepping keeps it; beyond the tolerance the first step returns NSDAE_WARN_PENETRATION.
 * projection = slop moves it out when the contact is closed. There a start deeper than a tenth of
 * the smaller body (nsdae_system_set_size) is an error. Where sizes are unknown the bound is that
 * of start_tol = 0.1. A larger start_tol accepts the start, nsdae_sim_project corrects it.
 *
 * Unless start_check is 0, each callback is called alone, once or twice, and checked. Derivatives
 * of Phi and g_N are compared with differences, at v = 0 and along two trial velocities. This takes
 * a few calls for any size; derivatives of nsdae_bodies_system are not compared. nsdae_system_check
 * checks more.
 *
 * - NSDAE_E_ARGUMENT, "q0" or "v0": inconsistent; the text has row, value and bound.
 *  nsdae_sim_project makes them consistent.
 * - NSDAE_E_ARGUMENT, "dt": below eps |t0|
 * - NSDAE_E_ARGUMENT, "t0" (penalty, event): eps |t0| > 20 rtol dt, and callbacks depend on t
 * - NSDAE_E_ARGUMENT, "atol" (penalty, event): coarser than the lengths of a row
 * - NSDAE_E_CONVERGENCE (event): no state without overlap nearby
 * - NSDAE_E_CALLBACK: a callback writes outside its array, or does not write an entry of Phi, g_N,
 *  dq/dt or U
 * - NSDAE_E_DERIVATIVE: a derivative has a gross error, such as a wrong sign */
NSDAE_API int nsdae_sim_init(nsdae_sim *sim, double t0, const double *q0, const double *v0);

/* Adds an observer, at most NSDAE_OBSERVERS_MAX. Observers are called in the order of these calls.
 */
NSDAE_API int nsdae_sim_observe(nsdae_sim *sim, nsdae_observer_fn observer, void *user);
/* Removes the observer that was added with these arguments; no error if there is none. */
NSDAE_API int nsdae_sim_unobserve(nsdae_sim *sim, nsdae_observer_fn observer, void *user);

/* Sets the interrupt function; NULL: none. It is called before every step, and after every internal
 * step of penalty and event. An interrupted step returns NSDAE_E_INTERRUPTED, and the state is the
 * one before it. The function may read what a signal handler sets; its calls on the simulation
 * return NSDAE_E_STATE. */
NSDAE_API int nsdae_sim_set_interrupt(nsdae_sim *sim, nsdae_interrupt_fn asked, void *user);

/* Takes one step of dt. Returns:
 *
 * - NSDAE_OK
 * - NSDAE_EVENT: an impact, or with method event a mode transition
 * - NSDAE_ZENO: event closed an accumulation of impacts
 * - NSDAE_STOPPED: an observer ended the run
 * - NSDAE_WARN_...: a warning, once per kind and run; the error record has its value
 * - < 0: the step failed and the state is the one before it
 *
 * Warnings (bounds in docs/methods/warnings.md):
 *
 * - NSDAE_WARN_ENERGY, _PENETRATION, _DRIFT: above the bound of the method
 * - NSDAE_WARN_PAINLEVE: event chose one of two solutions; the text names the frictional joint and
 *  its multiplier
 * - NSDAE_WARN_IMPACTS: a time-stepping step solved many consecutive impacts as one
 * - NSDAE_WARN_RESTITUTION: an impact had another restitution than e_N. penalty: by its law, in the
 *  first step. event: it was slower than the tolerance of velocities that another body sets
 * - NSDAE_WARN_CONTACT: a contact problem was left above its tolerance, see contact_give
 * - NSDAE_WARN_SINGULAR: event or implicit passed a singular pose of the constraints, beyond which
 *  two motions exist, on the one without a jump of velocities; the text names time and constraint
 */
NSDAE_API int nsdae_sim_step(nsdae_sim *sim);
/* Runs to t_end, or to the end of the first step for which nsdae_sim_step returns NSDAE_EVENT or
 * NSDAE_ZENO. Returns that status. */
NSDAE_API int nsdae_sim_run_to_event(nsdae_sim *sim, double t_end);

/* q [nq] and v [nv] at a time of the last step, including its ends. In an observer the last step is
 * the one of its record.
 *
 * - Time stepping: q is the parabola with dq/dt at both ends, v is linear. The accuracy is that of
 *  a step without impact (implicit: second order).
 * - penalty and event: the solution of the integrator, to its tolerances. It is integrated again
 *  from its last restart, and once more when the run continues.
 *
 * NSDAE_E_ARGUMENT: t is outside the last step; NSDAE_E_STATE: there is no last step (after
 * nsdae_sim_init, nsdae_sim_set_state or a failed step). */
NSDAE_API int nsdae_sim_interpolate(nsdae_sim *sim, double t, double *q, double *v);

/* Sets the last argument of the callbacks in this simulation, in place of the system's: workspace
 * or parameters of one simulation or thread. */
NSDAE_API int nsdae_sim_set_user(nsdae_sim *sim, void *user);
/* Changes options during a run, without allocation: dt (starts a new grid of steps), tolerances,
 * limits, stabilisation, contact laws. method, polygon, projection and threads are
 * fixed. If one of them differs, the call returns NSDAE_E_ARGUMENT, names the option and changes
 * nothing. The run continues from the current state. */
NSDAE_API int nsdae_sim_set_options(nsdae_sim *sim, const nsdae_sim_options *options);
/* Sets the coefficients of fixed contact i or frictional joint j in this simulation, in place of
 * the system's; those of a contact list are in its callback. A frictionless contact or joint must
 * remain frictionless, and a frictional joint must keep mu > 0: else NSDAE_E_ARGUMENT.
 * nsdae_sim_set_friction_bound sets the bound of a joint that has one in the system. The
 * callback joint_friction_bound, such as vary of a motor, adds to it. */
NSDAE_API int nsdae_sim_set_contact(nsdae_sim *sim, int i, double mu, double e_n, double e_t);
NSDAE_API int nsdae_sim_set_frictional_joint(nsdae_sim *sim, int j, double mu);
NSDAE_API int nsdae_sim_set_friction_bound(nsdae_sim *sim, int j, double bound);
/* Sets control i in this simulation: the target of motor i (nsdae_motor), in place of the constant
 * target. The next step begins with it; method event starts its integrator anew at the state.
 * Controls are part of the state: nsdae_sim_set_state restores them, nsdae_sim_init keeps them.
 *
 * NSDAE_E_ARGUMENT: no such motor, its target is a drive, or value is not finite. */
NSDAE_API int nsdae_sim_set_control(nsdae_sim *sim, int i, double value);
/* Control i into *value. NSDAE_E_ARGUMENT: as above. */
NSDAE_API int nsdae_sim_get_control(nsdae_sim *sim, int i, double *value);

enum { NSDAE_VALUES_MAX = 4 }; /* most values of a sensor */

/* The values of sensor i of nsdae_bodies_add_sensor at the present record, also in an observer:
 * nsdae_system_sensor_size of them. Forces and accelerations are means over the step, 0 at the
 * start and after nsdae_sim_set_state.
 *
 * NSDAE_E_ARGUMENT; NSDAE_E_STATE: before nsdae_sim_init. */
NSDAE_API int nsdae_sim_get_sensor(nsdae_sim *sim, int i, double *value);

/* Points [3 count] and forces [3 count] of the contacts of the present record, in the axes of
 * space, also in an observer. count is the number of contacts of the record. In the plane z is 0. A
 * point is midway between the surfaces of two solids [m]. The force is on the body of the larger
 * number, never the ground, and a mean over the step [N].
 *
 * A contact without an impulse, a limit, a rope and a contact of user rows have the point NaN and
 * the force 0. So have all contacts at the start and after nsdae_sim_set_state.
 *
 * NSDAE_E_ARGUMENT: NULL though count > 0, or the system was not made by nsdae_bodies_system;
 * NSDAE_E_STATE: before nsdae_sim_init. */
NSDAE_API int nsdae_sim_get_contact_forces(nsdae_sim *sim, double *point, double *force);

/* The complementarity problem of a step that failed with NSDAE_E_LCP, NSDAE_E_INFEASIBLE or
 * NSDAE_E_PAINLEVE. Its arrays belong to the simulation and are valid until the next step.
 * NSDAE_E_STATE: the last step did not fail in this way, or its contacts have the second-order cone
 * (see nsdae_sim_get_friction). */
NSDAE_API int nsdae_sim_get_failed_lcp(const nsdae_sim *sim, nsdae_lcp_problem *problem);

/* The contact problem of a step (nsdae/friction.h), with impulses [N s] and velocities [m/s],
 * contacts in their order. It has the global form, with the contacts and constraints of the largest
 * island that was solved with second-order cones; else the local form, of the only island. */
typedef struct nsdae_step_friction {
  nsdae_friction_problem problem; /* its arrays belong to the simulation */
  nsdae_friction_options options; /* options of its solve */
  const double *guess;            /* [rows] initial guess */
  const double *r, *u;            /* [rows] resulting impulses and velocities */
} nsdae_step_friction;

/* The contact problem of the last step of a time-stepping method, successful or failed; of an
 * iterated method that of the last iteration. The arrays belong to the simulation and are valid
 * until the next step. If its form is the global one, nsdae_friction_solve with these options and
 * this guess reproduces r exactly. Other problems were solved as complementarity problems.
 * NSDAE_E_STATE if the last step had no such problem:
 *
 * - no closed contact
 * - several islands, all solved as complementarity problems, or one of very many frictionless
 *   contacts
 * - frictional joints: their friction depends on a bilateral force, which has no cone
 * - methods event and penalty */
NSDAE_API int nsdae_sim_get_friction(nsdae_sim *sim, nsdae_step_friction *friction);
/* Takes steps of dt from the start time to t_end; the last one is shortened. A rest of less than
 * dt / 1000 is part of the step before it. Returns:
 *
 * - NSDAE_OK
 * - the first NSDAE_WARN_... of its steps, which does not end the run
 * - NSDAE_STOPPED
 * - < 0: a step failed and the state is the one before it */
NSDAE_API int nsdae_sim_run(nsdae_sim *sim, double t_end);

/* Size in bytes of the state block, which depends on system and options. A block contains all data
 * that the next step depends on:
 *
 * - time, q, v, grid of steps
 * - warm starts, modes, accumulations
 * - energy quadratures, statistics except wall_time
 *
 * A simulation of the same system and options continues from a block byte for byte like the
 * original run, in any process. The callbacks must be deterministic. A block is plain bytes in this
 * machine's byte order; it may be copied, stored and compared. */
NSDAE_API int nsdae_sim_state_size(const nsdae_sim *sim, size_t *size);
/* Fills block [size]. In an observer it is the state after the record. NSDAE_E_STATE: before
 * nsdae_sim_init; NSDAE_E_ARGUMENT: wrong size. */
NSDAE_API int nsdae_sim_get_state(nsdae_sim *sim, void *block, size_t size);
/* Sets the state from a block. Observers are not called for it. The lists of impacts and mode
 * transitions of the record are empty. On an error the state is unchanged:
 *
 * - NSDAE_E_ARGUMENT: damaged or not a block; or its version, system, method, options or
 *  coefficients differ. The text names the difference.
 * - NSDAE_E_NONFINITE: a value is NaN or infinite */
NSDAE_API int nsdae_sim_set_state(nsdae_sim *sim, const void *block, size_t size);

/* Last record, statistics, sizes. nsdae_sim_get_record returns NSDAE_E_STATE before nsdae_sim_init.
 */
NSDAE_API int nsdae_sim_get_record(const nsdae_sim *sim, nsdae_record *record);
NSDAE_API int nsdae_sim_get_stats(const nsdae_sim *sim, nsdae_stats *stats);
NSDAE_API int nsdae_sim_get_dims(const nsdae_sim *sim, nsdae_dims *dims);
/* 1 if the system has a callback for the potential energy, else 0. */
NSDAE_API int nsdae_sim_has_potential(const nsdae_sim *sim);
NSDAE_API int nsdae_sim_get_options(const nsdae_sim *sim, nsdae_sim_options *options);
/* The system of the simulation, for its names and sizes; NULL if sim is NULL. */
NSDAE_API const nsdae_system *nsdae_sim_get_system(const nsdae_sim *sim);
/* Error record of the last call on this simulation; if sim is NULL, a record that says so. If a
 * call of this thread was refused because another one was in progress, the record of that refusal.
 */
NSDAE_API const nsdae_error *nsdae_sim_error(const nsdae_sim *sim);

#ifdef __cplusplus
}
#endif
#endif
