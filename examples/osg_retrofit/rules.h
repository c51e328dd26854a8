// Tells the adapter the properties of the terrace that classic materials lack. Any thread.
#pragma once

#include "sideray_osg.h"

sideray_osg::Rules terrace_rules();
