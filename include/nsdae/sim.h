/* nsdae: integrating a system in time. BSD-3-Clause. */
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

/* A simulation; opaque. One call at a time uses it. A call is NSDAE_E_STATE and changes nothing
 * while another one that steps, starts or changes the simulation is in progress, in the same thread
 * (a callback) or in another. Calls that only read (nsdae_sim_get_record, _get_stats, _get_options,
 * _get_failed_lcp, nsdae_sim_state_size) may run at the same time. Observers: nsdae_observer_fn. */
typedef struct nsdae_sim nsdae_sim;

/* Index into nsdae_method_name; options.method. */
enum nsdae_method {
  NSDAE_METHOD_IMPLICIT,
  NSDAE_METHOD_IMPLICIT_PRINTED,
  NSDAE_METHOD_MOREAU,
  NSDAE_METHOD_PENALTY,
  NSDAE_METHOD_EVENT
};

/* Linear solvers of the integrator of event. */
enum nsdae_linear_solver { NSDAE_LINEAR_DENSE, NSDAE_LINEAR_SPARSE };

/* What to do where Phi_q has deficient rank. */
enum nsdae_redundant { NSDAE_REDUNDANT_ERROR, NSDAE_REDUNDANT_LEAST_NORM };

/* What a step of a time-stepping method ends with: its end is moved to the constraints (coordinates
 * of unit length, such as quaternions, keep it; with none they get it back when it has doubled or
 * halved); with contacts also to touching, where a contact was closed in the step and overlaps;
 * with depths instead no deeper than a contact was that overlapped at the step's begin and stayed
 * closed: it lasts, and on curved surfaces does not sink in by (1 - e_N) h^2 v^2 / (2 r) in every
 * step. With penalty and event anything but none is refused: event keeps both by its own, and
 * penalty's contacts overlap by their law. */
enum nsdae_projection {
  NSDAE_PROJECTION_NONE,
  NSDAE_PROJECTION_CONSTRAINTS,
  NSDAE_PROJECTION_CONTACTS,
  NSDAE_PROJECTION_DEPTHS
};

/* Fill with nsdae_sim_options_default first: a struct that was not is refused. */
typedef struct nsdae_sim_options {
  int method;                             /* enum nsdae_method */
  double dt;                              /* step [s] */
  double baumgarte_alpha, baumgarte_beta; /* of the smooth phases [1/s] */
  double iteration_tol;                   /* relative change that ends an implicit iteration */
  int iteration_max;                      /* at most so many per step */
  int redundant;                          /* enum nsdae_redundant */
  double rank_tol;                        /* below it a constraint depends on the others */
  double contact_tol;                     /* scaled natural residual of a solved LCP */
  int polygon; /* edges of the friction polygon where nt = 2: 3 .. 32; 0: Coulomb's cone itself */
  double impact_velocity;   /* slower closings are no impacts [m/s] */
  double rtol, atol;        /* of the integrator of penalty and event */
  int penalty_law;          /* enum nsdae_penalty_law */
  double penalty_stiffness; /* K [N/m^n] */
  double penalty_exponent;  /* n */
  double friction_velocity; /* regularisation of friction in penalty [m/s] */
  int linear_solver;        /* enum nsdae_linear_solver, of event */
  double accumulation_time; /* shorter rests of accumulations are closed [s] */
  int events_max;           /* of event in one dt; past it the step is implicit */
  int projection;           /* enum nsdae_projection */
  double start_tol;         /* relative error of the numbers of a start */
  int inner_steps_max;      /* of the integrator of penalty and event in one dt */
  int start_check;          /* 1: a start looks for gross errors of callbacks */
  int contacts_max;         /* most contacts of a list */
  int threads;              /* that share the islands of a step by blocks: 1 .. 256 */
  unsigned initialised;     /* set by nsdae_sim_options_default */
} nsdae_sim_options;

/* Every option at its default. */
NSDAE_API void nsdae_sim_options_default(nsdae_sim_options *options);
/* Sets one option from text, e.g. ("dt", "0.005") or ("method", "moreau"). NSDAE_E_OPTION: no
 * such key or choice (the text offers the nearest); NSDAE_E_ARGUMENT: outside its range. */
NSDAE_API int nsdae_sim_options_set(nsdae_sim_options *options, const char *key, const char *value,
                                    nsdae_error *error);
/* The table behind it: keys, units, ranges, defaults. */
NSDAE_API const nsdae_params *nsdae_sim_options_table(void);

/* Name of a method and what it is, in one line; NULL past the last. */
NSDAE_API const char *nsdae_method_name(int method);
NSDAE_API const char *nsdae_method_summary(int method);

/* One impact: what a contact did in one instant, or, for a time-stepping method, in one step. */
typedef struct nsdae_impact {
  double time;                  /* of the instant (penalty: of the first touch, which may be
                                   in an earlier step), or the end of the step [s] */
  int contact;                  /* from 0; by list: its place in the record's contacts */
  double normal_impulse;        /* [N s]; with a time-stepping method the step's force is in it */
  double tangential_impulse[2]; /* [N s], the first nt of them */
  double velocity_before, velocity_after; /* normal, of the contact [m/s] */
  double peak_force; /* largest normal force of a continuous contact [N]; 0 for a rigid one */
  int accumulation;  /* 1: stands for infinitely many impacts that end at time in rest */
} nsdae_impact;

/* A contact or frictional joint that changed its mode at an instant; method event alone finds them.
 */
typedef struct nsdae_change {
  double time;                 /* [s] */
  int contact;                 /* from 0; -1: a frictional joint */
  int frictional_joint;        /* from 0; -1: a contact */
  int mode_before, mode_after; /* enum nsdae_mode */
} nsdae_change;

/* Contacts by list that were closed in a step, in the order of the callback. */
typedef struct nsdae_contact_set {
  int count;                        /* 0 of a system whose contacts are numbered */
  const long *id;                   /* [count] */
  const int *block;                 /* [2 count] */
  const double *gap;                /* [count] where the method looked last: moreau in the middle of
                                       the step, implicit and implicit-printed at its end */
  const double *normal_impulse;     /* [count] of the step */
  const double *tangential_impulse; /* [count nt] */
  const int *mode;                  /* [count] enum nsdae_mode */
} nsdae_contact_set;

/* How far a step is from the laws, each figure with the contact or constraint of the largest (from
 * 0, of contacts by list its place in the record's contacts; -1: the figure is 0); and its energy:
 *
 *   energy = energy_start + work - dissipated + unexplained */
typedef struct nsdae_certificate {
  double pull;             /* max(0, -Lambda_N): a contact that pulls [N s] */
  double cone_excess;      /* max(0, |Lambda_T| - mu Lambda_N): friction beyond its cone [N s] */
  double penetration;      /* max(0, -g_N) [m] */
  double constraint_drift; /* max |Phi| [in its units] */
  double
      constraint_rate; /* max |dPhi/dt|: of moreau at the middle of the step, with v of its end */
  double complementarity; /* max |Lambda_N xi_N| [J], with xi_N = v_N(+) + e_N v_N(-) of time
                             stepping; of event xi_N = v_N of what is closed; of penalty 0 */
  double energy;          /* kinetic + potential, after the step [J] */
  double work;            /* of forces that are not in the potential, and of moving constraints and
                             contacts, since the start [J] */
  double dissipated;      /* work taken by contact and friction impulses since the start [J] */
  double unexplained;     /* since the start [J]: < 0: a loss, > 0: a gain of the method */
  int pull_contact, cone_contact, penetration_contact; /* contact of that figure, or -1 */
  int drift_constraint, rate_constraint;               /* constraint of that figure, or -1 */
  int complementarity_contact;                         /* contact of that figure, or -1 */
} nsdae_certificate;

/* The state after a step (or at the start, step = 0) and its certificate. Everything points into
 * the simulation and holds until the next step. */
typedef struct nsdae_record {
  long step;                        /* from 0, the start */
  double time;                      /* [s] */
  double duration;                  /* of the step [s]; 0: the start, or a state that was set */
  const double *q, *v;              /* [nq], [nv] */
  const double *acceleration;       /* [nv] mean over the step, impacts included; 0 at the start */
  const double *multiplier;         /* [m] mean bilateral force over the step */
  const double *gap;                /* [k] */
  const double *normal_impulse;     /* [k] of the step */
  const double *tangential_impulse; /* [k nt] */
  const double *normal_force;       /* [k] mean over the step [N], impacts included */
  const double *tangential_force;   /* [k nt] */
  const int *mode;                  /* [k] enum nsdae_mode */
  const double *frictional_joint_impulse; /* [f] friction of the frictional joints in the step */
  const double *frictional_joint_force;   /* [f] its mean force */
  const int *frictional_joint_mode; /* [f] NSDAE_MODE_SLIP or NSDAE_MODE_STICK; NSDAE_MODE_OPEN:
                                       frictionless */
  nsdae_contact_set contacts;       /* those by list; of numbered ones tell the arrays above */
  double kinetic, potential;        /* [J]; potential is 0 where no callback gives it */
  double dissipated;                /* work taken by all contact impulses so far [J] */
  double lcp_residual;        /* scaled natural residual, 0 where there was no LCP; of contacts by
                                 list that of friction.h, one over all contacts of the step */
  double constraint_drift;    /* max |Phi| */
  double penetration;         /* max(0, -g_N) over the contacts */
  const nsdae_impact *impact; /* [impacts] */
  int impacts;                /* in the step */
  const nsdae_change *change; /* [changes] */
  int changes;                /* in the step */
  nsdae_certificate certificate; /* how far the step is from the laws */
} nsdae_record;

/* Sees every record, once each. 0: go on; > 0: stop after it (NSDAE_STOPPED); < 0: the run fails
 * with this status and the state is the one before the step: it becomes the state when every
 * observer has seen it. The next step or run goes on with the observer that failed; those that saw
 * the record do not see it again, unless the step is not the same any more (another end, other
 * options, a state that was set): then the number of the step comes again, and stands for the one
 * before. The observer's own error may be left in *error, which comes cleared. It may ask the
 * simulation, and add or take out observers, itself too; what moves the simulation is
 * NSDAE_E_STATE. */
typedef int (*nsdae_observer_fn)(const nsdae_record *record, nsdae_error *error, void *user);

enum { NSDAE_OBSERVERS_MAX = 8 };

/* Asked whether a step in work is to end: non-zero says so. */
typedef int (*nsdae_interrupt_fn)(void *user);

/* What a simulation did since nsdae_sim_init. */
typedef struct nsdae_stats {
  long steps, smooth_steps, contact_steps;      /* all, without and with a contact closed */
  long lcps, lcp_pivots, iterations;            /* the last: of the implicit methods */
  long mass_evals, force_evals, jacobian_evals; /* calls of the callbacks */
  long impacts;                                 /* as recorded */
  long events, accumulations; /* of event: instants of change; accumulations closed */
  long fallback_steps;        /* of event: dt that were stepped by implicit instead */
  long accumulations_early; /* of event: closed before accumulation_time, as what parted was as slow
                               as rtol and atol, or rattled on after thousands of impacts */
  double rank_retained; /* the gap in the rank: the smallest sine of the angle to the others of a */
  double
      rank_discarded;  /* constraint that counts, the largest of one that does not; 1 and 0: none */
  int rank, rank_most; /* smallest and largest rank of Phi_q met; not the same: see rank_tol */
  double worst_residual;    /* over all LCPs */
  double worst_drift;       /* max |Phi| [in its units] */
  double worst_penetration; /* max(0, -g_N) [m] */
  double energy_start;      /* kinetic + potential at the start [J] */
  double energy_balance; /* energy now + dissipated - energy_start [J]; forces that are not in the
                            potential do their work here */
  int warnings; /* 1: energy, 2: penetration, 4: drift, 8: Painleve, 16: impacts, 32: restitution;
                   see NSDAE_WARN_ENERGY etc. */
  double wall_time;              /* spent in nsdae_sim_run and nsdae_sim_step [s] */
  int contact_capacity;          /* room in a list of contacts, which grows between steps */
  int contact_growths;           /* how often it grew */
  int islands;                   /* parts of the last step that contacts and constraints join */
  int island_contacts;           /* contacts of the largest of them */
  nsdae_certificate certificate; /* the largest figures of all records; the energies of the last */
} nsdae_stats;

/* Makes a simulation; this is where memory is allocated, once. The system must be complete, and is
 * constant as long as the simulation lives; options are copied, NULL for the defaults. error may be
 * NULL. NSDAE_E_ARGUMENT, NSDAE_E_STATE (a callback that is needed is missing), NSDAE_E_MEMORY, and
 * what a setter of the system was refused with (see nsdae_system_clear_error). */
NSDAE_API int nsdae_sim_create(const nsdae_system *system, const nsdae_sim_options *options,
                               nsdae_sim **sim, nsdae_error *error);
/* Releases it and sets *sim to NULL; NULL and a pointer to NULL are allowed. While another call on
 * the simulation is in progress, nothing is released and *sim stays. */
NSDAE_API void nsdae_sim_destroy(nsdae_sim **sim);

/* Puts a start right: changes q0 [nq] as little as can be, in the metric of M, so that it satisfies
 * the constraints and no contact overlaps (coordinates of unit length, such as quaternions, get
 * it), then v0 [nv] so that it satisfies theirs. The simulation is not started, its state not
 * changed. NSDAE_OK; NSDAE_E_CONVERGENCE (no such state near this one: the text names the row),
 * NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE, NSDAE_E_CALLBACK, NSDAE_E_MASS, NSDAE_E_MEMORY: q0 and v0
 * are as they were. */
NSDAE_API int nsdae_sim_project(nsdae_sim *sim, double t0, double *q0, double *v0);

/* Starts at t0 with q0 [nq], v0 [nv]; evaluates every term once. A start must satisfy the
 * constraints, their rates, unit lengths and, with event, 0 <= g_N, each up to
 * start_tol (default 1e-6, numbers of six digits; 1e300 takes anything) relative to its
 * terms:
 *   |Phi_i|, -g_N,i      <= start_tol (1 + |row|_1 max |q|)            row of Phi_q, column of W_N
 *   |Phi_q v + Phi_t|_i  <= start_tol (1 + |row|_1 max |v| + |Phi_t,i|)
 * NSDAE_E_ARGUMENT names the row, its value and the bound; nsdae_sim_project puts it right. event
 * moves a start that overlaps within the bound to g_N >= 0 by the least change in the metric of M
 * (NSDAE_E_CONVERGENCE: no such start is near). Time stepping keeps an overlap; beyond the bound
 * its first step returns NSDAE_WARN_PENETRATION. Each
 * callback is called alone, once or twice: NSDAE_E_CALLBACK where it writes beyond its array, or
 * leaves an entry of Phi, g_N, dq/dt or U out. Given derivatives of Phi and g_N are compared with
 * differences, with v = 0 and along two trial velocities (a few calls, whatever the size):
 * NSDAE_E_DERIVATIVE where one is grossly wrong, as by a sign; formulas of nsdae_bodies_system are
 * not compared. None of these where start_check is
 * 0. nsdae_system_check looks closer. The run counts time from t0, so that its steps do not depend
 * on t0. NSDAE_E_ARGUMENT names "dt" if it is below eps |t0|; with a tolerance (penalty, event)
 * "t0" if eps |t0| > 20 rtol dt and callbacks depend on t, "atol" if it is coarser than the lengths
 * of a row. May be called again to start anew. The observers see the
 * start as step 0, at the first step or run. */
NSDAE_API int nsdae_sim_init(nsdae_sim *sim, double t0, const double *q0, const double *v0);

/* Adds an observer, at most NSDAE_OBSERVERS_MAX; they are called in this order. */
NSDAE_API int nsdae_sim_observe(nsdae_sim *sim, nsdae_observer_fn observer, void *user);
/* Takes the observer that was added with these two out again; not found is no error. */
NSDAE_API int nsdae_sim_unobserve(nsdae_sim *sim, nsdae_observer_fn observer, void *user);

/* Who is asked before every step, and after every internal step of penalty and event, whether to go
 * on; NULL: nobody. A step that is interrupted was not done: NSDAE_E_INTERRUPTED, and the state is
 * the one before it. It may look at what a signal handler sets; its own calls on the
 * simulation are NSDAE_E_STATE. */
NSDAE_API int nsdae_sim_set_interrupt(nsdae_sim *sim, nsdae_interrupt_fn asked, void *user);

/* One step of dt. NSDAE_OK; NSDAE_EVENT when there was an impact in it, or with method event a
 * change of contact mode; NSDAE_ZENO when event closed an accumulation of impacts in it;
 * NSDAE_WARN_ENERGY, _PENETRATION or _DRIFT, once each, where these exceed what the method explains
 * (the error record says by how much; bounds in docs/methods/warnings.md); NSDAE_WARN_PAINLEVE,
 * once, where event took one of two solutions (the record names the frictional joint and its
 * multiplier); NSDAE_WARN_IMPACTS, once, if a time-stepping step solved many impacts that follow
 * one another as one; NSDAE_WARN_RESTITUTION, by the first step, if the law of penalty gives
 * another restitution than e_N; NSDAE_STOPPED; < 0: the step was not done and the state is the one
 * before it. */
NSDAE_API int nsdae_sim_step(nsdae_sim *sim);
/* The same, but back after the first step in which nsdae_sim_step would return NSDAE_EVENT or
 * NSDAE_ZENO, with that status. */
NSDAE_API int nsdae_sim_run_to_event(nsdae_sim *sim, double t_end);

/* q [nq] and v [nv] at a time of the last step, its ends included; called by an observer, of the
 * step that it sees. Time-stepping methods: q by the parabola with dq/dt at both ends, v by the
 * straight line, which is as good as their step where there is no impact in it (implicit: of second
 * order). penalty and event: the integrator's own solution, to its tolerances, for which it goes
 * there again from where it last started (as once more when the run goes on). NSDAE_E_ARGUMENT:
 * another time; NSDAE_E_STATE: there is no last step (after an init, a state that was set, a step
 * that failed). */
NSDAE_API int nsdae_sim_interpolate(nsdae_sim *sim, double t, double *q, double *v);

/* What the callbacks get as user in this simulation, in place of the system's: scratch, or
 * parameters of its own, such as for each thread. */
NSDAE_API int nsdae_sim_set_user(nsdae_sim *sim, void *user);
/* Other options from here on, without making anything anew: dt (a new grid of steps starts here),
 * tolerances, limits, stabilisation, laws. method, polygon, linear_solver and projection are fixed:
 * NSDAE_E_ARGUMENT by name, and everything is as before. The run goes on from the state. */
NSDAE_API int nsdae_sim_set_options(nsdae_sim *sim, const nsdae_sim_options *options);
/* Coefficients of contact i and of frictional joint j in this simulation, in place of the system's.
 * What is without friction in the system stays so, and frictional joints with friction keep some:
 * NSDAE_E_ARGUMENT. */
NSDAE_API int nsdae_sim_set_contact(nsdae_sim *sim, int i, double mu, double e_n, double e_t);
NSDAE_API int nsdae_sim_set_frictional_joint(nsdae_sim *sim, int j, double mu);

/* The complementarity problem of the step that failed with NSDAE_E_LCP, NSDAE_E_INFEASIBLE or
 * NSDAE_E_PAINLEVE; its arrays are the simulation's and hold until the next step. NSDAE_E_STATE
 * where the last step did not fail so, or had contacts with the cone: nsdae_sim_get_friction. */
NSDAE_API int nsdae_sim_get_failed_lcp(const nsdae_sim *sim, nsdae_lcp_problem *problem);

/* The contact problem of a step, of nsdae/friction.h: contacts in their order, impulses [N s],
 * velocities [m/s]. In the local form; of contacts by list in the global one, with the contacts and
 * constraints of the large islands. */
typedef struct nsdae_step_friction {
  nsdae_friction_problem problem; /* its arrays are the simulation's */
  nsdae_friction_options options; /* as it was solved */
  const double *guess;            /* rows: where the solver began */
  const double *r, *u;            /* rows: impulses and velocities that it ended with */
} nsdae_step_friction;

/* That of the last step of a time-stepping method, done or failed; of an iterated one, of its last
 * iteration. The arrays are the simulation's and hold until the next step. Where contacts have the
 * cone (two tangential directions, polygon = 0), nsdae_friction_solve with these options and from
 * this guess gives r again to the last bit, and so it does of contacts by list; other problems were
 * solved as complementarity problems. NSDAE_E_STATE where the last step had no such problem: no
 * closed contact, contacts by list in small islands alone, frictional joints without a cone (the
 * friction of a slide goes with a bilateral force, which has no cone), methods event and penalty.
 */
NSDAE_API int nsdae_sim_get_friction(nsdae_sim *sim, nsdae_step_friction *friction);
/* Steps of dt from the start's time to t_end; the last one is shortened to end there. NSDAE_OK; the
 * first NSDAE_WARN_... of its steps, which does not end the run;
 * NSDAE_STOPPED; < 0: a step failed, the state is the one before it. */
NSDAE_API int nsdae_sim_run(nsdae_sim *sim, double t_end);

/* The state as a value: a block of *size bytes, fixed by system and options, that holds all that
 * the next step depends on (time, q, v, the grid of steps, warm starts, modes, accumulations,
 * accounts, statistics but for the clock). Set into a simulation of the same system and options,
 * now or in another process, the run goes on with the same bytes as without, if the callbacks give
 * the same. Plain bytes of this machine's byte order: copied, kept and compared at will. */
NSDAE_API int nsdae_sim_state_size(const nsdae_sim *sim, size_t *size);
/* Fills block [size]; called by an observer it is the state right after the record it sees.
 * NSDAE_E_STATE before nsdae_sim_init; NSDAE_E_ARGUMENT: another size. */
NSDAE_API int nsdae_sim_get_state(nsdae_sim *sim, void *block, size_t size);
/* Sets it; the observers have seen it. A block that is none, damaged, of another version, system,
 * method, or with other options or coefficients that matter to the method is NSDAE_E_ARGUMENT by
 * name, a number that is not finite NSDAE_E_NONFINITE: the state is then the one before. The lists
 * of impacts and changes of the record are empty. */
NSDAE_API int nsdae_sim_set_state(nsdae_sim *sim, const void *block, size_t size);

/* The last record; NSDAE_E_STATE before nsdae_sim_init. */
NSDAE_API int nsdae_sim_get_record(const nsdae_sim *sim, nsdae_record *record);
NSDAE_API int nsdae_sim_get_stats(const nsdae_sim *sim, nsdae_stats *stats);
NSDAE_API int nsdae_sim_get_dims(const nsdae_sim *sim, nsdae_dims *dims);
/* 1 where the system has a callback for the potential energy, else 0. */
NSDAE_API int nsdae_sim_has_potential(const nsdae_sim *sim);
NSDAE_API int nsdae_sim_get_options(const nsdae_sim *sim, nsdae_sim_options *options);
/* The system that it was made of, for its names and sizes; NULL of NULL. */
NSDAE_API const nsdae_system *nsdae_sim_get_system(const nsdae_sim *sim);
/* Why the last call on this simulation failed; of NULL a record that says so. After a call of this
 * thread that was refused because another one was in progress: the record of that refusal. */
NSDAE_API const nsdae_error *nsdae_sim_error(const nsdae_sim *sim);

#ifdef __cplusplus
}
#endif
#endif
