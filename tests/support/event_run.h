/* A run of the event-driven method, kept whole: what a test of it looks at. */
#ifndef EVENT_RUN_H
#define EVENT_RUN_H

#include <nsdae/nsdae.h>

enum { EVENT_RUN_KEPT = 4000, EVENT_RUN_NQ = 8, EVENT_RUN_K = 8 };

typedef struct event_run {
  /* asked for: event_run_default fills it */
  nsdae_sim_options options;
  double t0, t_end;
  nsdae_observer_fn look; /* NULL, or sees every record after it was kept */
  void *user;

  /* what came of it */
  nsdae_dims dims;
  int status, impacts, changes, records;
  nsdae_impact impact[EVENT_RUN_KEPT];
  nsdae_change change[EVENT_RUN_KEPT];
  double t, q[EVENT_RUN_NQ], v[EVENT_RUN_NQ];              /* of the last record */
  double normal[EVENT_RUN_K], tangential[2 * EVENT_RUN_K]; /* impulses over the whole run */
  double multiplier[EVENT_RUN_NQ];                         /* integrals over the whole run */
  int mode[EVENT_RUN_K];
  nsdae_stats stats;
  nsdae_error error;
} event_run;

/* Method event with dt 0.01, rtol 1e-10, atol 1e-12, from t0 = 0. */
void event_run_default(event_run *run);

/* Whether EVENT_RUN_BY_LIST is set: systems without frictional joints are run with a contact list,
 * whose contacts are differenced where the fixed ones are: then omega is a difference of
 * differences. */
int event_run_by_list(void);

/* Runs the system from t0 to t_end; the system stays. Asserts what holds of any run that does not
 * fail: certificate columns finite and at tolerance, records and events in order, restitution at
 * every impact. */
void event_run_do(event_run *run, nsdae_system *system, const double *q0, const double *v0);

/* The same with integrator = dopri5, then dop853; asserts that both give the same. */
void event_run_both(event_run *run, nsdae_system *system, const double *q0, const double *v0);

/* Prints what a run did. */
void event_run_print(const event_run *run);

#endif
