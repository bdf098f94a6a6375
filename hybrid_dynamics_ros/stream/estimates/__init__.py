"""What measured efforts show beside the motion: force at the tool."""
