# What CPack reads before it installs what it packs: the lists of what is in the packages must be whole
# (cmake/install.cmake).
set(ENV{FASCICLE_PACKING} 1)
