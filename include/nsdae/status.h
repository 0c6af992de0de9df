/* nsdae: status codes and the error record. BSD-3-Clause.
 *
 * Every function returns int:
 *
 * - 0: success
 * - < 0: failure; nothing was done
 * - > 0: success with additional information */
#ifndef NSDAE_STATUS_H
#define NSDAE_STATUS_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* X(name, value, message): this list defines the enum, the names and the messages. */
#define NSDAE_STATUS_LIST(X)                                                          \
  X(NSDAE_OK, 0, "done")                                                              \
  X(NSDAE_EVENT, 2, "an impact or a mode transition in this step")                    \
  X(NSDAE_ZENO, 3, "an accumulation of impacts was closed")                           \
  X(NSDAE_STOPPED, 4, "an observer asked to stop")                                    \
  X(NSDAE_WARN_ENERGY, 5, "the energy gain exceeds the bound of the method")          \
  X(NSDAE_WARN_PENETRATION, 6, "the penetration exceeds the bound of the method")     \
  X(NSDAE_WARN_DRIFT, 7, "the constraint drift exceeds the bound of the method")      \
  X(NSDAE_WARN_PAINLEVE, 8, "friction forces are not unique (Painleve)")              \
  X(NSDAE_WARN_IMPACTS, 9, "consecutive impacts were solved as one")                  \
  X(NSDAE_WARN_RESTITUTION, 10, "an impact had another restitution than its own e_N") \
  X(NSDAE_WARN_CONTACT, 11, "a contact problem was left above its tolerance")         \
  X(NSDAE_WARN_MODEL, 12, "the model may have a mistake")                             \
  X(NSDAE_WARN_SINGULAR, 13, "a singular pose, beyond which two motions exist")       \
  X(NSDAE_E_MEMORY, -1, "out of memory")                                              \
  X(NSDAE_E_ARGUMENT, -2, "an argument is missing or out of its range")               \
  X(NSDAE_E_OPTION, -3, "unknown option or parameter")                                \
  X(NSDAE_E_STATE, -4, "not possible in the present state of the object")             \
  X(NSDAE_E_CALLBACK, -5, "a callback reported a failure")                            \
  X(NSDAE_E_NONFINITE, -6, "a value is NaN or infinite")                              \
  X(NSDAE_E_MASS, -7, "the mass matrix is not positive definite")                     \
  X(NSDAE_E_RANK, -8, "the constraint Jacobian has deficient rank")                   \
  X(NSDAE_E_LCP, -9, "a complementarity problem was not solved")                      \
  X(NSDAE_E_INFEASIBLE, -10, "a complementarity problem has no solution")             \
  X(NSDAE_E_CONVERGENCE, -11, "an iteration did not converge")                        \
  X(NSDAE_E_DERIVATIVE, -12, "a derivative disagrees with differences")               \
  X(NSDAE_E_IO, -13, "a file could not be read or written")                           \
  X(NSDAE_E_UNSUPPORTED, -14, "not built into this library")                          \
  X(NSDAE_E_PAINLEVE, -15, "no contact force exists, or more than one (Painleve)")    \
  X(NSDAE_E_INTERRUPTED, -16, "interrupted by the caller")

/* Status codes. */
enum nsdae_status {
#define NSDAE_STATUS_ENUM(name, value, message) name = value,
  NSDAE_STATUS_LIST(NSDAE_STATUS_ENUM)
#undef NSDAE_STATUS_ENUM
};

/* Error record. It belongs to the handle of the call. Functions without a handle have it as their
 * last argument, which may be NULL. All texts are one line, without a line feed. */
typedef struct nsdae_error {
  int status;        /* enum nsdae_status; NSDAE_OK without an error */
  int code;          /* code of the origin: return value of a callback, info of LAPACK; else 0 */
  int index;         /* entry, contact or pivot, from 0; -1 if not applicable */
  double time;       /* simulated time [s]; NaN if not applicable */
  char argument[32]; /* argument, option or callback; "" if not applicable */
  char where[48];    /* function that detected it */
  char text[256];    /* argument, value, bound and remedy */
} nsdae_error;

/* Name ("NSDAE_E_RANK") and message of a status; "unknown status" for any other value. */
NSDAE_API const char *nsdae_status_name(int status);
NSDAE_API const char *nsdae_status_message(int status);

#ifdef __cplusplus
}
#endif
#endif
