/* Of the tests of friction. */
#include "../../support/random.h"
