/* All methods. */
#ifndef NSDAE_METHODS_H
#define NSDAE_METHODS_H

#include "method.h"

extern const nsdae_stepping nsdae_stepping_implicit, nsdae_stepping_printed, nsdae_stepping_moreau,
    nsdae_stepping_penalty, nsdae_stepping_event;

/* NULL past the last; the order is that of enum nsdae_method. */
const nsdae_stepping *nsdae_stepping_of(int method);

#endif
