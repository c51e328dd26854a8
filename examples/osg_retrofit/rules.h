// Declares the engine owner's rules for the terrace: facts that its classic materials do not express. Any thread.
#pragma once

#include "sideray_osg.h"

sideray_osg::Rules terrace_rules();
