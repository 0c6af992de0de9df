/* What a simulation is made of. */
#ifndef NSDAE_SIM_IMPL_H
#define NSDAE_SIM_IMPL_H

#include <stdatomic.h>
#include <stdint.h>

#include <nsdae/sim.h>

#include "slop_projection.h"
#include "state_projection.h"
#include "stepper.h"
#include "method.h"

/* Who uses a simulation now. A call that changes it works alone. Calls that only read it may work
 * at the same time, in several threads. While an observer sees a record, its thread may read the
 * simulation and ask it, and nothing else. Every other call is NSDAE_E_STATE and touches neither
 * the simulation nor its error record: callbacks, threads of a pool and other threads alike. */
enum nsdae_use {
  NSDAE_READ, /* reads: with others, and from an observer */
  NSDAE_ASK,  /* works alone, but changes no state: also from an observer */
  NSDAE_MOVE, /* works alone */
  NSDAE_END   /* works alone, also after a callback that did not return */
};

/* The stack grows downwards: a call in a callback has its frame below that of the call which it is
 * in. A call of the same thread whose frame is not below shows that a callback did not return. */
typedef struct nsdae_guard {
  atomic_int users;             /* calls that read; NSDAE_ALONE: one that works; NSDAE_LEFT */
  _Atomic(const void *) thread; /* of the one that works alone; else NULL */
  int showing;                  /* an observer sees a record; for that thread alone */
  uintptr_t frame;              /* of the one that works alone */
  const char *where;            /* its name */
} nsdae_guard;

/* A callback left the one that worked alone by an exception or longjmp: only destroy remains. */
enum { NSDAE_ALONE = -1, NSDAE_LEFT = -2 };

/* Bits of nsdae_stats.warnings, in the order in which monitors.c reports them. */
enum {
  NSDAE_MONITORS_ENERGY = 1,
  NSDAE_MONITORS_PENETRATION = 2,
  NSDAE_MONITORS_DRIFT = 4,
  NSDAE_MONITORS_PAINLEVE = 8,
  NSDAE_MONITORS_IMPACTS = 16,
  NSDAE_MONITORS_RESTITUTION = 32,
  NSDAE_MONITORS_CONTACT = 64,
  NSDAE_MONITORS_SINGULAR = 128
};

/* Largest values of the run so far, for the bounds of monitors.c: doubles alone, see snapshot.c. */
typedef struct nsdae_monitors {
  double change;   /* g */
  double row, way; /* c, l */
  double apart;    /* the largest gap so far; 0: all were closed at the start */
  double scale;    /* largest kinetic energy so far */
  double known;    /* the largest that came from somewhere */
  double kinetic;  /* of the start */
  double reported; /* bound of the gain of the steps when it was first exceeded */
} nsdae_monitors;

typedef struct nsdae_observation {
  nsdae_observer_fn call;
  void *user;
} nsdae_observation;

typedef struct nsdae_observers {
  nsdae_observation of[NSDAE_OBSERVERS_MAX];
  int count;
  int turn;    /* the next to see the record that is shown */
  int stop;    /* one of those before wants the run to stop */
  int telling; /* one is being called */
} nsdae_observers;

/* Work of forces, inertia and of moving constraints and contacts, see certificate.c: in the last
 * step, where a time-stepping method did it, and in all. */
typedef struct nsdae_work {
  double potential;               /* at the start [J] */
  double forces, inertia, driven; /* of the step; inertia less what a projection lifted */
  double power, earlier;          /* F v at its end (NAN: it jumped there), and at its begin */
  double sum;                     /* of all steps, whoever did them */
  double turnover, carried;       /* amounts, of forces and of driven in all steps */
  double unsure, rounding;        /* of the work of forces: what its quadrature may miss */
  double spent, gained;           /* by contact impulses: amounts; what they gave */
  double turned;                  /* that lasting contacts took because their normals turn */
} nsdae_work;

/* What is kept of all steps so far, beside the last result. */
typedef struct nsdae_accounts {
  long step, grid_count;     /* number of the last; steps end at grid_start + grid_count dt */
  double dissipated, raised; /* [J] */
  double grid_start;
  nsdae_stats stats;
  nsdae_monitors watch;
} nsdae_accounts;

/* A point of the run: a result and the accounts up to it. */
typedef struct nsdae_point {
  nsdae_result result;
  nsdae_accounts accounts;
  nsdae_work work;
  nsdae_record record; /* made of them */
  double *acceleration, *normal_force, *tangential_force,
      *frictional_joint_force; /* means of the step */
  double *angle;               /* of sensors, followed from the start */
} nsdae_point;

void nsdae_point_layout(nsdae_point *point, nsdae_arena *arena);
/* Where the arrays of its record are: again after lists grew. */
void nsdae_point_show_arrays(nsdae_point *point);

/* What was done with the points. */
typedef struct nsdae_stage {
  int started;         /* nsdae_sim_init was called */
  int told;            /* the observers have seen the state */
  int between;         /* next is the step before the state */
  int waiting;         /* next is whole, and is the state as soon as the observers have seen it */
  int failed;          /* the last step ended on the complementarity problem of next */
  double asked;        /* the time that the step in next was asked for */
  nsdae_error start;   /* a warning of the start: the first step without one returns it */
  nsdae_error warning; /* of the last step, reported when it is done */
} nsdae_stage;

/* Room in every list; slots of tracked contacts, and how many there were before they grew. */
typedef struct nsdae_lists {
  nsdae_room contacts, rows;
  int growths;
  int slots, slots_before;
} nsdae_lists;

/* Of the maker's system. */
typedef struct nsdae_controls {
  double *value, *before; /* as many as the maker has; those of a state that is being read */
  nsdae_maker_user user;
} nsdae_controls;

struct nsdae_sim {
  const nsdae_system *system; /* held while the simulation lives */
  nsdae_system model;         /* a copy with user and coefficients of its own; of tracked contacts
                                 they are numbered: k is the number of slots */
  nsdae_tracked tracked;      /* which they are */
  nsdae_sim_options options;
  nsdae_guard guard;
  nsdae_error error;
  nsdae_arena arena;
  nsdae_stepper stepper;
  const nsdae_stepping *method;
  void *own; /* the method's */
  nsdae_projector projection;
  nsdae_slop_projection slop;
  double *probe;           /* at the start: callbacks alone, accelerations, what is watched */
  nsdae_point point[3];    /* those below */
  nsdae_point *now, *next; /* the state; a step in work, or the step before the state */
  nsdae_point *aside;      /* a third, for what is between two, where the method integrates */
  nsdae_stage stage;
  nsdae_observers observers;
  double wall_time;
  nsdae_lists lists;
  nsdae_controls control;
};

/* What a size of the model leads to: sizes of what has one, then its arrays (of a simulation), then
 * what the method works with: own, to be destroyed if it fails. */
void nsdae_sim_measure(nsdae_sim *sim);
void nsdae_sim_layout(void *sim, nsdae_arena *arena);
int nsdae_sim_make_method(nsdae_sim *sim);

/* More room in every list, as the one that was full calls for. NSDAE_OK, NSDAE_E_MEMORY, and
 * NSDAE_E_ARGUMENT where contacts_max is met: everything is as before. */
int nsdae_sim_grow(nsdae_sim *sim);
/* k slots, more than there are: everything by contact has room for them. NSDAE_OK, NSDAE_E_MEMORY,
 * NSDAE_E_ARGUMENT where the method has a limit: as before. */
int nsdae_sim_make_slots(nsdae_sim *sim, int k);
int nsdae_sim_most_slots(const nsdae_sim *sim); /* that limit */
/* Puts into the slots what the list has near the terms' point, as far as a motion of a time h
 * comes. NSDAE_OK, NSDAE_ARRAYS_GROW, the failure of a callback. */
int nsdae_sim_track(nsdae_sim *sim, nsdae_terms *at, double h);
/* The memory of a method into one of another number of slots. */
void nsdae_sim_carry_memory(const nsdae_sim *sim, const nsdae_memory *from, int from_slots,
                            nsdae_memory *to, int slots);
/* Room for what contacts and rows took at t, taken [2]: half as much again; with the same errors.
 */
int nsdae_sim_enlarge(nsdae_sim *sim, double t, const nsdae_room *taken, nsdae_room *contacts,
                      nsdae_room *rows);
/* Room for at least as much. */
int nsdae_sim_make_room(nsdae_sim *sim, const nsdae_room *contacts, const nsdae_room *rows);

/* What an observer sees: the step that waits for it, else the state. */
static inline const nsdae_point *nsdae_sim_shown(const nsdae_sim *sim)
{
  return sim->observers.telling && sim->stage.waiting ? sim->next : sim->now;
}

/* NSDAE_OK, or NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE naming what is no state; where: the function. */
int nsdae_sim_check_state(nsdae_sim *sim, const char *where, double t0, const double *q0,
                          const double *v0);

/* Puts next in the place of the state. */
void nsdae_sim_commit(nsdae_sim *sim);

/* Of contact i, as nsdae_system_set_size gave it; 0: not known. */
double nsdae_contact_size(const nsdae_system *system, int i);

/* NSDAE_OK, or NSDAE_E_ARGUMENT with the reason why the run cannot be resolved from there. */
int nsdae_start_resolved(nsdae_sim *sim, const nsdae_terms *start);

/* From nsdae_sim_init: next, whose terms and memory are set, as the start of a run. */
int nsdae_point_start(nsdae_sim *sim, nsdae_point *point);
/* The record of a step of that length, its impacts, certificate and statistics, from its result and
 * from the point before. NSDAE_OK, or what the terms return. */
int nsdae_point_follow(const nsdae_sim *sim, nsdae_point *before, nsdae_point *point,
                       double length);

/* The certificate of a record whose energies are there: of a start, and of a step, with its work;
 * in the statistics, too. NSDAE_OK, or what the terms return. */
int nsdae_certificate_start(const nsdae_sim *sim, nsdae_point *point);
int nsdae_certificate_follow(const nsdae_sim *sim, nsdae_point *before, nsdae_point *point);
/* Of event: NSDAE_OK, or NSDAE_E_CONVERGENCE if T changed by more than rtol explains. */
int nsdae_certificate_energy(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point);

/* NSDAE_OK, or NSDAE_E_NONFINITE with the record that names what of a point is not finite. */
int nsdae_point_finite(const nsdae_point *point);
/* NSDAE_WARN_IMPACTS with the pair of closed contacts that would hit most often, one after the
 * other, in the step that was done and has its work; or NSDAE_OK. */
int nsdae_merged_report(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point);

/* The result and record of a step by slots as a contact list has them; place [k]: room. Last. */
void nsdae_point_list(nsdae_point *point, int *place);

/* The record of a point whose result and accounts were set; have: terms to evaluate besides. */
int nsdae_point_show(nsdae_point *point, unsigned have);

/* Shows a record to the observers whose turn it is. NSDAE_OK, NSDAE_STOPPED, or the failure of one,
 * whose turn it then still is. */
int nsdae_observers_tell(nsdae_sim *sim, const nsdae_record *record);

/* ---- users of a simulation */

/* A call of a public function. */
typedef struct nsdae_call {
  const nsdae_sim *sim;
  enum nsdae_use use;
  const char *where;             /* the function */
  uintptr_t frame;               /* its address */
  int entered, nested, returned; /* nested: by an observer */
} nsdae_call;

/* NSDAE_OK; NSDAE_E_ARGUMENT where sim is NULL; NSDAE_E_STATE: refused. */
int nsdae_sim_enter(nsdae_call *call);
/* At the end of each call, also if an exception of a callback passes through it. */
void nsdae_sim_leave(nsdae_call *call);

#define NSDAE_CALL(use, where)                                      \
  {                                                                 \
    sim, use, where, (uintptr_t)__builtin_frame_address(0), 0, 0, 0 \
  }

/* Heads the body of a public function, of these parameters and arguments, which is called between
 * enter and leave. */
#define NSDAE_SIM_CALL(use, name, parameters, ...)                                       \
  static int name##_guarded parameters;                                                  \
  int name parameters                                                                    \
  {                                                                                      \
    __attribute__((cleanup(nsdae_sim_leave))) nsdae_call call_ = NSDAE_CALL(use, #name); \
    int guarded_ = nsdae_sim_enter(&call_);                                              \
    if (guarded_ == NSDAE_OK) guarded_ = name##_guarded(__VA_ARGS__);                    \
    call_.returned = 1;                                                                  \
    return guarded_;                                                                     \
  }                                                                                      \
  static int name##_guarded parameters

/* ---- starts */

/* Whether the terms' point may be a start: NSDAE_OK, or NSDAE_E_ARGUMENT naming the row, its value
 * and its bound, NSDAE_E_DERIVATIVE where derivatives are grossly wrong. NSDAE_WARN_PENETRATION:
 * time stepping starts from an overlap beyond start_tol. The terms and the groups of unit length
 * are those of the start; work has nsdae_initial_size numbers. */
int nsdae_initial_check(nsdae_projector *projection, nsdae_terms *start, double *work);

/* Of the overlaps of the start: NSDAE_OK, NSDAE_WARN_PENETRATION, or NSDAE_E_ARGUMENT where event
 * cannot begin, or where projection = slop would move bodies by more than a tenth of them. */
int nsdae_initial_overlap(nsdae_terms *start, const nsdae_sim_options *options);

/* Moves the start of event to gaps >= 0 and to the constraints if a contact overlaps: the least
 * change in the metric of M. 1: moved; NSDAE_OK: nothing to do; NSDAE_E_CONVERGENCE naming the
 * worst row, and what the terms return. */
int nsdae_initial_touch(nsdae_sim *sim, nsdae_terms *start);

/* NSDAE_OK, or with method penalty NSDAE_WARN_RESTITUTION naming the contact whose law is furthest
 * from e_N; of those with an impulse [k], NULL: of all. */
int nsdae_initial_law(const nsdae_system *system, const nsdae_sim_options *options,
                      const double *impulse, nsdae_error *error);

/* Numbers that the check works on: accelerations of contacts and frictional joints, given and
 * differenced. */
size_t nsdae_initial_size(const nsdae_dims *dims);

/* ---- monitors */

/* From the start on. NSDAE_OK, or what the terms return. */
int nsdae_monitors_start(const nsdae_sim *sim, nsdae_point *point);
/* After a step: the warning of now, NSDAE_WARN_... with the error record, or NSDAE_OK. */
int nsdae_monitors_step(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point);

/* ---- options */

/* NSDAE_OK, or NSDAE_E_ARGUMENT naming the first option outside its range. */
int nsdae_sim_options_check(const nsdae_sim_options *options, nsdae_error *error);

/* The projection, or what auto stands for. */
int nsdae_sim_projection(const nsdae_sim_options *options);

/* An option as a number. */
double nsdae_sim_option_value(const nsdae_sim_options *options, const nsdae_param *param);

/* Whether a run of this method depends on it. */
int nsdae_sim_option_matters(const char *key, int method);

/* ---- All methods. */

extern const nsdae_stepping nsdae_stepping_implicit, nsdae_stepping_printed, nsdae_stepping_moreau,
    nsdae_stepping_penalty, nsdae_stepping_event;

/* NULL past the last; the order is that of enum nsdae_method. */
const nsdae_stepping *nsdae_stepping_of(int method);

#endif
