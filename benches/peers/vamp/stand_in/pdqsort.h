// The same algorithm by the same author as Boost has it.
#pragma once

#include <boost/sort/pdqsort/pdqsort.hpp>

using boost::sort::pdqsort;
using boost::sort::pdqsort_branchless;
