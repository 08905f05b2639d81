# CPack reads this before it installs what it packs: the lists of package contents must be complete
# (cmake/install.cmake).
set(ENV{FASCICLE_PACKING} 1)
