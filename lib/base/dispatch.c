#include "dispatch.h"

int nsdae_dispatch_plain = 0;
