"""Error against run time, scene by scene, of the package and of other methods: tables, pictures, and a page of both."""
