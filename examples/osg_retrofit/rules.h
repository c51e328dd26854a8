// What this engine's owner tells the adapter about the terrace: what its classic materials do not say. Any thread.
#pragma once

#include "sideray_osg.h"

sideray_osg::Rules terrace_rules();
